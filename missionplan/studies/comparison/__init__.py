"""What changed between two reports of one command, and whether it is more than Monte-Carlo noise.

Read first `compare`, then `summary_numbers` (what is compared), `significance` (the tests) and `mission_changes`.
"""
