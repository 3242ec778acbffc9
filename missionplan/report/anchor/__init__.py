"""Report of `size-anchor`.

Read `page` (the answer, the order of the sections), then `sections`; `drawing` draws the anchor in section, `figures`
its drag and its dive.
"""
