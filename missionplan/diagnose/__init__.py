"""Measured data in; what the simulation gets wrong, why, and what the extended model gains out."""
