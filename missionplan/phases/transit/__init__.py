"""Transit by dead reckoning in legs, with fixes at the surface between them (Briggs et al., section IV).

Read first `plan` (parameters and record), then `transit`, `leg_loop` and `ground_velocity`; `compensation` and
`kalman_filter` are the ways to compensate drift. Without Monte Carlo: `rice_panels` (the quadrature), `expectation`
(cost by an integral equation) and `policy` (optimal legs by dynamic programming).
"""
