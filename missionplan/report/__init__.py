"""Pictures of results: self-contained HTML, figures, GeoJSON and KML."""
