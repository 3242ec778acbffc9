"""Phases of a mission: models that take a block of trials through one part of it.

Read first `hooks` (what one phase hands to the next, how effects act) and `currents`, then the phases themselves:
`transit`, `mooring`, `transition_plan` with `transition_simulation` (Palmer, Hearn & Stevenson). Currents of ocean
models: `gridded_current`, on `grids` and a `lattice`. What a way may meet: `place`, with `ground` and `zones`.
"""
