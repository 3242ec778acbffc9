"""JSON schemas of mission, vehicle and data set files, for completion and checks in editors.

`schema` puts them together from the models that read the files; `sections` writes a model, `values` a quantity, and
`effects` the catalogue.
"""
