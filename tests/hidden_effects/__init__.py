"""Data sets with an effect hidden in them, made by code that shares nothing with the package under test.

A case is a base mission, a data set and the truth behind it. Only mission and data set reach the tool, and only
through its command line. Nothing here imports the package: the physics is written afresh from the papers, with
another integrator and other shapes of each effect, so that agreement is evidence.

``python -m tests.hidden_effects --cases 400`` prints the confusion matrix and the figures asked for.
"""
