"""Results of the studies as frozen data classes, with their summaries and tables.

`base` has what all results share; every other module holds the result of one study, `mooring` those of anchors.
"""
