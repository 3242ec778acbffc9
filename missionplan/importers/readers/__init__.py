"""Readers of the formats, one a module; each has an `IMPORTER`. Libraries are imported when a file is read."""
