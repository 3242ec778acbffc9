"""Currents on the grids of ocean models.

`grids` says of which columns a place is made up and where they have water, `lattice` serves regular grids and meshes,
`gridded_current` interpolates in time and depth between the columns' values.
"""
