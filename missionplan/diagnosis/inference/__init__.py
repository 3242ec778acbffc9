"""Bayesian comparison of candidate causes, for any model that satisfies `model.Model`; nothing here knows a vehicle.

Read first `model` (the protocol, and fits by it), then `selection` and `posterior`; `gauss_newton` finds the mode of a
nonlinear model; `marginal_likelihood`, `laplace` and `importance_sampling` compute evidences; `cross_validation` scores
predictions of held-out data and their intervals; `prior` holds slabs with heavy tails; `adequacy`
looks at what a fit leaves, `experiment_design` at what to measure next.
What is reported is in the data classes of `missionplan.results.learned.evidence`.
"""
