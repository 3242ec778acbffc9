"""Legs of a track.

Read `cutting` first, then `fixes`, `candidates`, `judging`; `made_reckoning` and `vehicle_current` are for vehicles
that freeze their position under water, or carry it with a current of their own.
"""
