"""Tank data: drag, free oscillation and thrust. Read first `model`, then `forward` and `linearised`."""
