"""Report of `simulate`.

Read `page` (the answer, the order of the sections), then `sections` (what each says), `quantities` (requirements and
failures in words) and `figures`; `tracks` writes GeoJSON and KML.
"""
