"""Slowing down to hover over a grid of manoeuvres (Palmer, Hearn & Stevenson): `sweep_transition`, and its page."""
