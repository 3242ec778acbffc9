"""Transit by dead reckoning in legs, with fixes at the surface between them (Briggs et al., section IV).

Read first `plan` (parameters and record), then `transit`, `leg_loop` and `ground_velocity`; `compensation` and
`kalman_filter` are the ways to compensate drift. `analytic` holds expectations without Monte Carlo.
"""
