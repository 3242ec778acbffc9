"""Report of `simulate`.

Read `page` (the answer, the order of the sections), then `sections` and `sensitivities` (what each section says), and
the figures: `figures` (waterfall, timeline), `histograms`, `maps` and `close_ups`.
"""
