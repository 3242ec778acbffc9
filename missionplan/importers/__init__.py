"""A vehicle's own logs to a data set.

A reader (`readers`, one a make; `importer`, `mapping` and `netcdf` are what they share) turns files into a `track`.
`dives` says where legs may be, `cutting` makes legs of them, `judging` says which fixes and legs count, and
`reckoning` serves vehicles that freeze their position under water, or carry it with a current of their own.
`importing` puts it together.
"""
