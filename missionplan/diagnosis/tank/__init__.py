"""Tank data: towed drag, free oscillation, thrusters and propeller transients.

Read `forward` (rows, what all kinds have in common, one of the measurements), then `fitting` and `model`. `kind` is
what `diagnose` calls: it binds a mission with what that knows already, has a propeller's transient, lists residuals
and writes the causes.
"""
