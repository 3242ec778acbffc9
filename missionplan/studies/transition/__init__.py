"""Slowing down to hover over a grid of manoeuvres (Palmer, Hearn & Stevenson).

Read first `sweep_transition` (the study), then `grid_runs` (the model over the grid).
"""
