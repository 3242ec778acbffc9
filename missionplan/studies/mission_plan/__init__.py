"""The plan of a mission as a vehicle takes it: `build`; `export` writes it."""
