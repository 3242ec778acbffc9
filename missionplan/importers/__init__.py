"""A vehicle's own logs to a data set.

A reader (`readers`, one a make; they share `importer`, `mapping` and `readers.netcdf`) makes a `track` of files.
`dives` says where legs may be, `cutting` makes legs of them, `judging` says which fixes and legs count, and
`reckoning` serves vehicles that freeze their position under water, or carry it with a current of their own.
`importing` puts it together.
"""
