"""What was planned, on every report of a mission: `section` (with quantities in words) and `site_map`."""
