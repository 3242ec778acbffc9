"""Bayesian comparison of candidate causes, for any model that satisfies `model.Model`; nothing here knows a vehicle.

Read first `model` (the protocol, and fits by it), then `selection` and `weighing`; `gauss_newton` finds the mode of a
nonlinear model; `marginal_likelihood`, `set_evidence`, `laplace` and `importance_sampling` compute evidences; `prior`
holds slabs with heavy tails. `block_covariance` is the covariance of all data, whatever their kind: densities,
innovations, predictions of a part by the rest. `responses` have no name and compete with the causes; `discrepancy` and
`residual_tests` look at what a fit leaves, `cross_validation` at predictions of held-out data, `experiment_design` and
`trials` at what to measure next. What is reported is in the data classes of `missionplan.results.learned.evidence`.
"""
