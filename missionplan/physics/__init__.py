"""Pure functions of SI floats and arrays: one physical effect, one function."""
