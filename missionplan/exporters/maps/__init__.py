"""The plan for maps, plotters and geographic information systems; `geometry` and `colours` are shared with reports."""
