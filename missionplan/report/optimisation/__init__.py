"""Report of `optimise`."""
