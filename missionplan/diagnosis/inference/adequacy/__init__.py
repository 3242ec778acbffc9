"""Whether a model is adequate: what it leaves, smooth or not white, and groups that it does not predict."""
