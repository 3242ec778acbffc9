"""A result at a glance: on a terminal (`table`, `text`) and in a notebook (`notebook`).

`presenter` is what `missionplan.rendering` knows of reports: all the ways in which a result is shown.
"""
