"""The plan of a mission as a vehicle takes it: `build`, then `durations` and `single_interval`; `export` writes it."""
