"""Transition from survey speed to hover (Palmer, Hearn & Stevenson).

Read first `plan` (parameters and record), then `controllers` and `simulation`.
"""
