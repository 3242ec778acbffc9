"""Anchors: which one to build, and how often it is enough.

Read first `size_anchor`, then `sizing` (one anchor, and dives with it) and `lightest_anchor` (the search).
"""
