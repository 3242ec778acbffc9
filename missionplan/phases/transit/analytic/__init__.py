"""Transits without Monte Carlo: expected cost by an integral equation, optimal legs by dynamic programming.

Read first `rice_panels` (the quadrature), then `expectation` and `policy`.
"""
