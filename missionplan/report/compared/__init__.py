"""Reports of `compare`: two runs of one command, and alternatives side by side."""
