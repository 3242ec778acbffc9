"""What was planned, on every report of a mission: `section`, on `values` (a quantity in words) and `site_map`."""
