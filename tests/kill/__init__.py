"""Killed runs: ``python -m tests.kill`` ends simulations at random moments and resumes them (see `runs`)."""
