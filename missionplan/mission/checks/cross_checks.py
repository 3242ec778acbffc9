"""What pydantic cannot see in one section alone: phases in order, names, requirements, correlations."""

from collections import Counter
from difflib import get_close_matches
from typing import Any

import numpy as np

from missionplan.errors import Problem
from missionplan.mission.checks.requirements import check_requirement
from missionplan.mission.reading.documents import Document, Path_
from missionplan.mission.schema.mission import Mission, Requirement
from missionplan.mission.schema.phases import MoorPhase, TransitPhase
from missionplan.mission.schema.site import Geographic


def cross_check(mission: Mission, document: Document) -> list[Problem]:
    """List what is wrong between the sections of a mission."""
    return [
        *_check_phases(mission, document),
        *_check_site(mission, document),
        *_check_correlations(mission, document),
    ]


def _phase_path(mission: Mission, index: int) -> Path_:
    return ("phases", index, mission.phases[index].kind)


def _check_phases(mission: Mission, document: Document) -> list[Problem]:
    problems = []
    counts = Counter(phase.name for phase in mission.phases)
    for index, phase in enumerate(mission.phases):
        path = _phase_path(mission, index)
        if phase.name == "total" or counts[phase.name] > 1:
            problems.append(
                document.problem((*path, "name"), f"given {phase.name!r}; each phase needs a name of its own")
            )
        if not isinstance(phase, TransitPhase):
            continue
        if index == 0 and phase.start is None:
            problems.append(document.problem((*path, "from"), "missing; the first transit says where it starts"))
        if index > 0 and phase.start is not None:
            message = "only the first phase has `from`; later ones start where the last one ended"
            problems.append(document.problem((*path, "from"), message))
        no_origin = mission.site is None or mission.site.origin is None
        for key, position in (("from", phase.start), ("to", phase.to)):
            if isinstance(position, Geographic) and no_origin:
                message = "given latitude and longitude, but the mission has no site.origin"
                problems.append(document.problem((*path, key), message))
        has_propeller = mission.vehicle is not None and mission.vehicle.propulsion is not None
        if phase.shaft_rate is not None and not (has_propeller and mission.site and mission.site.water):
            message = "a speed from the shaft rate needs vehicle.propulsion and site.water"
            problems.append(document.problem((*path, "shaft_rate"), message))
        if mission.navigation is None:
            problems.append(document.problem(path, "a transit needs the section `navigation`"))
    names = [phase.name for phase in mission.transits]
    if mission.sweep.phase is not None and mission.sweep.phase not in names:
        message = f"given {mission.sweep.phase!r}, expected a transit: {', '.join(names)}"
        problems.append(document.problem(("sweep", "phase"), message))
    return problems


def _check_site(mission: Mission, document: Document) -> list[Problem]:
    if mission.site is None or not isinstance(mission.site.current, tuple):
        return []
    problems = []
    above = 0.0
    for index, layer in enumerate(mission.site.current):
        if isinstance(layer.down_to, float):
            if layer.down_to <= above:
                message = "layers go from the surface down; this one ends above the last"
                problems.append(document.problem(("site", "current", index, "down_to"), message))
            above = layer.down_to
    layers = mission.site.current
    if layers and isinstance(mission.site.depth, float) and 0.0 < above < mission.site.depth - 1e-6:
        message = f"the deepest layer ends at {above:.4g} m, the seafloor is at {mission.site.depth:.4g} m"
        problems.append(document.problem(("site", "current"), message))
    for index, phase in enumerate(mission.phases):
        given = phase.design_current if isinstance(phase, MoorPhase) else None
        if isinstance(given, tuple) and len(given) != len(layers):
            message = f"has {len(given)} speeds; site.current has {len(layers)} layers"
            problems.append(document.problem((*_phase_path(mission, index), "design_current"), message))
    return problems


def _check_correlations(mission: Mission, document: Document) -> list[Problem]:
    problems = []
    uncertain = mission.uncertain()
    for index, correlation in enumerate(mission.correlations):
        for side, name in enumerate(correlation.between):
            if name not in uncertain:
                close = get_close_matches(name, list(uncertain), n=1)
                path = ("correlations", index, "between", side)
                message = (
                    f"given {name!r}, expected a quantity that is a distribution: {', '.join(uncertain) or 'none is'}"
                )
                problems.append(document.problem(path, message, f"did you mean {close[0]}?" if close else ""))
    if not problems and mission.correlations:
        names = list(uncertain)
        matrix = np.eye(len(names))
        for correlation in mission.correlations:
            i, j = (names.index(name) for name in correlation.between)
            matrix[i, j] = matrix[j, i] = correlation.rho
        if np.linalg.eigvalsh(matrix).min() < 1e-10:
            problems.append(
                document.problem(("correlations",), "together these correlations are impossible (or exactly ±1)")
            )
    return problems


def read_requirements(mission: Mission, document: Document) -> tuple[tuple[Requirement, ...], list[Problem]]:
    """Read the bounds of the requirements, which need the phases' kinds for their units."""
    problems: list[Problem] = []
    requirements = []
    for index, requirement in enumerate(mission.requirements):
        item: dict[str, Any] = {key: getattr(requirement, key) for key in ("quantity", "at_most", "at_least")}
        bounds, wrong = check_requirement(item, mission.phases)
        problems += [document.problem(("requirements", index, key), message) for key, message in wrong]
        requirements.append(requirement.model_copy(update=bounds))
    return tuple(requirements), problems
