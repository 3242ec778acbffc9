"""Calibration of `diagnose`: truths drawn from the stated prior, data by code that shares nothing with the model."""
