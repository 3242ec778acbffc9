"""What to choose so that all requirements hold at the least energy or time.

Read first `optimise`, then `choosable` (what may be chosen), `evaluations` (trials of choices, kept, and how far they
are from the requirements) and `search`.
"""
