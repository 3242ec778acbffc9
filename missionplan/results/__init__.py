"""Frozen results of the studies, with their tables."""
