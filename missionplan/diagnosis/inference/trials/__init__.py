"""What a further experiment is worth, free of missions: `experiment` and `decision`."""
