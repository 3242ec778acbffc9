"""Results of the studies as frozen data classes, with their summaries and tables.

`base` has what all results share; every other module holds the result of one study. `learned` are those from
measurements; those that one study alone reads lie with it.
"""
