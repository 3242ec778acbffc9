"""Report of `simulate`: the page, its figures and its maps."""
