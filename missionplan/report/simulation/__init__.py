"""Report of `simulate`.

Read `page` (the answer, the order of the sections), then `sections` (what each says), `quantities` (requirements and
failures in words), and the figures: `figures` (waterfall, timeline, histograms) and `maps`.
"""
