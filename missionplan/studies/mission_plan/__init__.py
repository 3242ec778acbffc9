"""The plan of a mission as a vehicle takes it: `export` makes and writes it, of the phases in `phases`."""
