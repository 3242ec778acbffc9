"""Missions from above: what is drawn (`plan_view`), and its export as GeoJSON and KML."""
