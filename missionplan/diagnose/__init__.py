"""Measured data in; what the simulation gets wrong, why, and what the extended model gains out."""

from missionplan.diagnose.study import diagnose

__all__ = ["diagnose"]
