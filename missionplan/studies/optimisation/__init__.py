"""What to choose so that all requirements hold at the least energy or time.

Read first `optimise`, then `choices` (what may be chosen), `evaluations` (trials of choices, kept), `judging` (how far
a choice is from the requirements) and `search`.
"""
