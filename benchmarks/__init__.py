"""Speed relative to reference programs, measured in one run: ``python -m benchmarks`` (`validation/measured`)."""
