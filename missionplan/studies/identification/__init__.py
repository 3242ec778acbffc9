"""Drag, added mass and thruster constants from tank data: one module a kind of data, one fitting routine.

Read first `identify`, then `least_squares`.
"""
