"""Names that would do harm where they served as keys or ids, or were written unescaped."""
