"""How long should legs be? One d_max for all (`sweep_dmax`), or a table against the distance left (`plan_legs`).

Read first `sweep_scenario` (the transit), `cells` and `integral_equation` (its analytic cost); then
`optimise_legs`, which stands on `analytic_transit`, `leg_spread`, `paired_trials` and `policy_search`; then
`robustness` and `plan_comparison`, which evaluate its legs.
"""
