"""Reports of results: self-contained HTML pages, figures, terminal tables, GeoJSON and KML.

Read `page` (what a report is made of) and `render` (which module presents which result), then a study's module:
`simulation.page`, `anchor.page`, `leg_length.sweep`, ... `quantities` writes values in the reader's units, `wording`
rounds and names them; `plan_view` draws what tracks and circles of error look like from above.
"""
