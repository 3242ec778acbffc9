"""Faults of a maintainer's kind planted in the package, each judged by the tests nearest to it: ``python -m tests.mutation``."""
