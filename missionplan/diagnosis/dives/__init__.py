"""Dive logs: model, linearisation and designs of further dives. Read first `model`, then `forward` and `linearised`."""
