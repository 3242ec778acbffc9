"""Bayesian comparison of candidate causes, for any model that satisfies `model.Model`; nothing here knows a vehicle.

Read first `model` (the protocol, fits by it, predictions of held-out data), then `selection` and `weighing`;
`gauss_newton` finds the mode of a nonlinear model; `marginal_likelihood` and `evidence_approximations` compute
evidences; `prior` holds slabs with heavy tails. `block_covariance` is the covariance of all data, whatever their kind:
densities, innovations, predictions of a part by the rest. `discrepancy` looks at what a fit leaves, `experiment_design`
at what to measure next. What is reported is in the data classes of `missionplan.results.learned.evidence`.
"""
