"""Phases of a mission: models that take a block of trials through one part of it.

Read first `state` (what one phase hands to the next), `currents` and `hooks` (how effects act), then the phases
themselves: `transit`, `mooring`, `transition`.
"""
