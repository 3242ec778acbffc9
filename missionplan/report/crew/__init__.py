"""Reports in the units of the crew: `conversion` of a text, `pages` of a whole page."""
