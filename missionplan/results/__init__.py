"""Results of the studies as frozen data classes, with their summaries and tables.

`base` has what all results share; every other module holds the result of one study. Folders: `mooring` (anchors),
`leg_length`, `learned` (from measurements), `choosing` (explore, optimise, compare), `log_book` (score, history).
"""
