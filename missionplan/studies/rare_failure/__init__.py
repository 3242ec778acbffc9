"""How does the ten-thousandth mission fail? Rare failures by subset simulation on the normals of a mission.

Read first `find_rare_failure`, then `event` (what counts as failure), `margins` (how near a trial came to each failure)
and `driven_trials` (missions run from given normals, the task of a worker).
"""
