"""Named random streams, blocks of trials, fan-out and streaming statistics."""
