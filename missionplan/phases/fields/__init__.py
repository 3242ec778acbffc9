"""Currents on the grids of ocean models.

`grids` says of which columns of water a place is made up, `lattice` those of regular grids and triangles,
`gridded_current` interpolates in time and depth between the columns' values.
"""
