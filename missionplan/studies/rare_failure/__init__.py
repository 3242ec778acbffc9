"""How does the ten-thousandth mission fail? Rare failures by subset simulation on the normals of a mission.

Read first `find_rare_failure` (with the result), then `driven_trials` (what counts as failure, how near a trial came to
each, and missions run from given normals, the task of a worker).
"""
