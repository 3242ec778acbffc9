"""Report of `explore`: curves or maps, the best cells, windows and the front."""
