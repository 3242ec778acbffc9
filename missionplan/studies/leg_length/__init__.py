"""How long should legs be? One d_max for all (`sweep_dmax`), or a table against the distance left (`plan_legs`)."""
