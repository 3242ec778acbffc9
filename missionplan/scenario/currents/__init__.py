"""Currents from files: `csv_series` for a record at one place, and the fields of ocean models.

`field` recognises which model wrote the files and reads them; `files` joins several in time, `area` says what part of
them a mission needs, and `regular`, `roms`, `fvcom` and `ugrid` (SCHISM too) know one kind of grid each. `vertical` has
the depths of their layers.
"""
