"""Navigation logs: from legs between fixes to a model of their velocity errors.

Read `likelihood` (what the causes add to a leg, and the noise), `fitting`, `terms`, then `model`. Beside them:
`smooth_axes` (along which a discrepancy may be smooth), `fit_checks`, `designs` of further legs.
"""
