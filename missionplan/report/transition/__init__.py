"""Report of `sweep-transition`: the page, and its figures after those of Palmer, Hearn & Stevenson."""
