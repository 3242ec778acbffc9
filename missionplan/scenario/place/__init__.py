"""Ground, coast and tide of a mission, read from files: `building` makes a `Place` of what the readers return."""
