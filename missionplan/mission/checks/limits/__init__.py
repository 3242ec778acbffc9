"""What the world allows: keys and relations between keys that are impossible (errors) or unusual (notices).

Read first `table`, one row a key with its source, then `ranges` (a mission against the table) and `relations` (keys
against each other). What varies from trial to trial is checked again in each trial, by the phases.
"""
