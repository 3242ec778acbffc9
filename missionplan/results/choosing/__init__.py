"""Results of choosing: `explore`, `optimise`, and `compare` of missions."""
