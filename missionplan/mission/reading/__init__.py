"""YAML with line marks (`documents`), included files, and validation errors as problems with file and line."""
