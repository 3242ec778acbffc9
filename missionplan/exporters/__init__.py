"""Forms of the plan: one module a format, each with a title, what it cannot hold, and the files that it writes.

All of them take `missionplan.results.plan.Plan` and know neither missions nor phases. `formats` lists them; read
`table` first, then `vehicles.slocum` and `vehicles.moos`.
"""
