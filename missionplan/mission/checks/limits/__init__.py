"""What the world allows: keys and relations between keys that are impossible (errors) or unusual (notices).

Read first `ranges` (a mission against what its keys declare, see `mission.schema.limits`) and `relations` (keys
against each other). What varies from trial to trial is checked again in each trial, by the phases.
"""
