"""Summaries of dives, a few numbers each, with the model of dive logs.

Read first `dives`, then `model` here: the same descent, from which other quantities are taken. `kind` is what the
diagnosis uses.
"""
