"""Missions from above: what is drawn, in a frame (`plan_view`), and its export as GeoJSON and KML (`tracks`)."""
