"""Report of `diagnose`: `page`, the causes and `findings` in words, their `evidence`, the `plan`, and a `campaign`."""
