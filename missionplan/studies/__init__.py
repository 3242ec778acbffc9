"""Questions asked of a mission: one module a question."""
