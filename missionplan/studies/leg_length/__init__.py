"""How long should legs be? One d_max for all (`sweep_dmax`), or a table against the distance left (`plan_legs`).

Read first `sweep_scenario` (the transit, run for every d_max), then `analytic_transit` (its expected cost, and families
of tables), `paired_trials` and `optimise_legs`; `plan_legs` evaluates the legs found.
"""
