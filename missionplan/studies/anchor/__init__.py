"""Anchors: which one to build, and how often it is enough.

Read first `size_anchor`, then `trials` (dives with one anchor) and `search` (the lightest anchor that does).
"""
