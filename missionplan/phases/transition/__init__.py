"""Transition from survey speed to hover (Palmer, Hearn & Stevenson).

Read first `plan` (parameters and record), then `simulation`, with its controllers.
"""
