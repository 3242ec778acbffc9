"""Navigation logs: from legs between fixes to a model of their velocity errors.

Read `likelihood` (what the causes add to a leg, and the noise), `fitting`, `terms`, then `model`. Beside them: `axes`
(along which a discrepancy may be smooth), `joint_columns` (whitened once for all sets), `constancy` (what a log cannot
show), `designs` of further legs, `one_step`.
"""
