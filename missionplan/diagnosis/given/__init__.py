"""Effects that a mission carries already, as a diagnosis holds them: `effects`, and their `priors` from the mission."""
