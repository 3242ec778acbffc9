"""Dive logs: depth against time, dive by dive.

Read `preparation` (logs as they are fitted), `forward` (the descent phase under many settings), `priors`, `linearised`,
`noise` and `likelihood`, `fitting` (search from `starts`), then `model`. Beside them: `discrepancy_axes` along which a
discrepancy may be smooth, `consistency` of dives with each other, and `designs` of further dives. `kind` is what
`diagnose` calls, with residuals.
"""
