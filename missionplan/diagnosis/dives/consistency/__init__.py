"""Whether dives agree with each other: a claimed cause the same in all, and the labels of their weights."""
