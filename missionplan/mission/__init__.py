"""The YAML edge: mission files in, validated missions in SI out."""

from missionplan.mission.loading import load
from missionplan.mission.mission import Mission

__all__ = ["Mission", "load"]
