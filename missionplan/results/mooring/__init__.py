"""Results of moorings: `sizing` (of `size-anchor`), `sized_anchor` (one anchor), `held_vehicle` (on its line)."""
