"""Bayesian comparison of candidate causes, for any model that satisfies `model.Model`; nothing here knows a vehicle.

Read first `model` (the protocol), then `selection`, `likelihood`, `importance_sampling`, `cross_validation`,
`discrepancy`, `residual_tests` and `experiment_design`.
"""
