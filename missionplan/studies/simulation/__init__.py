"""Will the mission work? Blocks of trials through all phases, reduced as they finish.

Read first `simulate`, then `trial_block` (one block), `block_statistics` (its statistics) and `outcome_builder`;
for a vehicle that does not come back `overdue` (times, and areas), then `losses` (where trials end) and `drift`.
"""
