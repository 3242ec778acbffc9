"""From a file's text to a `Mission`: YAML with line marks, includes, and problems in words."""
