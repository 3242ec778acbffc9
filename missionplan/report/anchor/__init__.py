"""Report of `size-anchor`: the page and its figures."""
