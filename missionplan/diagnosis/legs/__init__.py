"""Navigation logs: from legs between fixes to a model of their velocity errors.

Read `mean` (what the causes add to a leg), `covariance` and `markov_covariance` (the noise and its likelihood),
`fitting`, then `model`. Beside them: `axes` (along which a discrepancy may be smooth), `modulation` of tidal and
inertial currents, `designs` of further legs, `one_step`.
"""
