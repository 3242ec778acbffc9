"""Currents from files: records at one place, and the fields of ocean models.

`reading` recognises which model wrote the files and reads them; `files` joins several in time, `area` says what part of
them a mission needs, `regular` (ROMS too) and `unstructured` (FVCOM, UGRID, SCHISM) know the kinds of
grids, and `vertical` the depths of their layers.
"""
