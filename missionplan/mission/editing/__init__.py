"""Changes of a mission in Python: keys as people name them, numbers in SI, and the file's text with its comments.

`keys` finds what a key means, `units` writes numbers as text with a unit, `changes` applies changes to a mission's
data, and `yaml_text` edits the text of a file where its data have changed.
"""
