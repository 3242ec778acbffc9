"""What changed between two reports of one command, and which of several missions is better, beyond chance.

Read first `compare_missions`, then `two_reports` with `summary_numbers` (what is compared, and the tests).
"""
