"""Page of `tide`: the constituents, what is left, and the fragment of a mission."""
