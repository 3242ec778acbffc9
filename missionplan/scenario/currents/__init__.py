"""Currents from files: a record at one place, and the fields of ocean models.

`field` reads records, and recognises which model wrote a field and reads it; `files` joins several in time, `area` says
what part of them a mission needs, `regular` (ROMS too) and `unstructured` (FVCOM, UGRID, SCHISM) know the kinds of
grids, and `vertical` the depths of their layers.
"""
