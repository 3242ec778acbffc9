"""Report of `simulate`.

Read `page` (the answer, and what each section says), then `quantities` (requirements and failures in words, inputs that
matter) and `figures`; `tracks` writes GeoJSON and KML.
"""
