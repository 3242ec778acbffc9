"""Will the mission work? Blocks of trials through all phases, reduced as they come.

Read first `simulate`, then `trial_block` (one block), `block_statistics` (what is kept of it) and `outcome_builder`.
"""
