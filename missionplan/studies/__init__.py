"""Questions asked of a mission or of data: one folder a question, the study named as its command.

`simulation` (will it work?), `leg_length`, `anchor`, `transition`, `identification` (tank data), `comparison` (of two
reports), and `init` (the starter folder).
"""
