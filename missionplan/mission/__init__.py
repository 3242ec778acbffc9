"""Mission files: YAML in, validated missions in SI out.

Read first `loading` and `mission`, then `schema` (the sections), `reading` (YAML, included files, problems with their
lines) and `checks` (between sections). `views` are missions with all that one kind of phase needs; `units` and
`geodesy` convert.
"""

from missionplan.mission.loading import MissionOrPath, as_mission, load
from missionplan.mission.mission import Mission

__all__ = ["Mission", "MissionOrPath", "as_mission", "load"]
