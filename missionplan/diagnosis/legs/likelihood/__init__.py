"""Likelihood of a log's legs: what the causes add to the mean, and the covariance of the errors.

Read `mean`, then `covariance`; beside them `modulation` of tidal and inertial currents, `hyperparameters` with their
priors, and the banded `markov_covariance`.
"""
