"""The YAML edge: mission files in, validated missions in SI out."""

from missionplan.mission.reading.load import load
from missionplan.mission.schema.mission import Mission

__all__ = ["Mission", "load"]
