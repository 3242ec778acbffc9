"""Vehicles that are diagnosed mission after mission: see `__main__`."""
