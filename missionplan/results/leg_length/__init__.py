"""Legs: `sweep` over d_max, the table of `legs` planned, and what plans cost in other cases (`leg_cases`)."""
