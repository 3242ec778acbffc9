"""JSON schemas of files and summaries, for completion and checks in editors.

`schema` puts them together from the models that read the files; `sections` writes a model.
"""
