"""Slowing down to hover over a grid of manoeuvres (Palmer, Hearn & Stevenson)."""
