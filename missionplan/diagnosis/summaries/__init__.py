"""Summaries of dives, a few numbers each, under the model of dive logs."""
