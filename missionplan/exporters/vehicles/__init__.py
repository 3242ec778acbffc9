"""The plan as vehicles take it, each by its own conventions of units, frames and names."""
