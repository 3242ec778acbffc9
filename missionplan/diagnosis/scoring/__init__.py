"""How well a mission as it stands predicts measured legs and dives; nothing is fitted.

`legs` and (for dives) `score` make an `ensemble.Ensemble` of a data set: what the mission expects of each value in many
draws of its uncertain quantities, by the phases that `simulate` runs, and the covariance of what is random besides.
`predictive` turns it into distributions of each value, with the past of the record or without; `rules` scores these,
`yardsticks` predicts the same values without the mission, `score` is the study.
"""
