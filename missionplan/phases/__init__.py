"""One module a phase: a model that moves a block of trials through one part of the mission."""
