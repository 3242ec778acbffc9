"""What changed between two reports of one command, and which of several missions is better, beyond chance.

Read first `compare`, then `two_reports` with `summary_numbers` (what is compared), `significance` (the tests) and
`mission_changes`; then `compare_missions`.
"""
