"""Tracks and circles of error for other programs: GeoJSON, KML, and the view in plan that both draw."""
