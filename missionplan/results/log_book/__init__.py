"""Results that tell how a mission fares beside what was measured, and what it learned from mission to mission."""
