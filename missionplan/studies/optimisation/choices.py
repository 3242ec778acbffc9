"""What may be chosen: the axes of a lattice, from the mission's section `optimise` or from options."""

import itertools
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.schema.sweep import ChoiceSection
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.results.choosing.exploration import Axis
from missionplan.studies.exploration.key_paths import check_key
from missionplan.studies.exploration.variation import NUMBER, read_axis

Point = tuple[int, ...]
"""A choice: an index along each axis."""
STEPS = 40
"""Steps between the bounds of a key whose step is not given."""
OPTION = "choose"


@dataclass(frozen=True)
class Lattice(Sequence[Mapping[str, object]]):
    """Every combination of the values of some axes, numbered with the last axis running fastest."""

    axes: tuple[Axis, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Values of each axis."""
        return tuple(len(axis.values) for axis in self.axes)

    def __len__(self) -> int:
        return math.prod(self.shape)

    def __getitem__(self, number: int) -> Mapping[str, object]:  # type: ignore[override]  # slices have no use
        return self.values_at(tuple(int(i) for i in np.unravel_index(number, self.shape)))

    def number(self, point: Point) -> int:
        """Return the number of a point."""
        return int(np.ravel_multi_index(point, self.shape))

    def values_at(self, point: Point) -> dict[str, object]:
        """Return the values by key path."""
        pairs = zip(self.axes, point, strict=True)
        return {key: axis.values[index] for axis, index in pairs for key in axis.keys}

    def neighbours(self, point: Point) -> Iterator[Point]:
        """Yield points one step away in one axis, or in each of two; along an axis without numbers, any other value."""
        moves = [(axis, step) for axis in range(len(self.axes)) for step in self._steps(axis, point[axis])]
        pairs = [(one, two) for one, two in itertools.combinations(moves, 2) if one[0] != two[0]]
        for combined in (*((move,) for move in moves), *pairs):
            moved = list(point)
            for axis, step in combined:
                moved[axis] += step
            yield tuple(moved)

    def _steps(self, axis: int, at: int) -> list[int]:
        count = self.shape[axis]
        reach = (-1, 1) if self.axes[axis].numbers is not None else range(-at, count - at)
        return [step for step in reach if step and 0 <= at + step < count]


def read_lattice(mission: Mission, texts: Sequence[str]) -> Lattice:
    """Return what may be chosen: by the options, or else by the mission's section `optimise`.

    Raises
    ------
    InputError
        When there is nothing to choose, or a key or its values are wrong.
    """
    problems: list[Problem] = []
    axes: list[Axis] = []
    sections = [] if texts else list(mission.optimise.choose)
    for text in texts:
        try:
            axes.append(read_axis(mission, text))
        except InputError as error:
            problems += [replace(problem, key=OPTION) for problem in error.problems]
    for number, section in enumerate(sections):
        try:
            axes.append(_axis(mission, section))
        except InputError as error:
            place = f"optimise.choose[{number}]"
            problems += [replace(problem, file=mission.file, key=place) for problem in error.problems]
    if not problems and not axes:
        hint = "optimise: {choose: [{key: ingress.speed, from: 1 m/s, to: 2 m/s}]} in the mission, or --choose"
        problems.append(Problem("missing; what may be chosen", mission.file, key="optimise.choose", hint=hint))
    keys = [key for axis in axes for key in axis.keys]
    twice = sorted({key for key in keys if keys.count(key) > 1})
    problems += [Problem(f"{key} is chosen twice", mission.file, key="optimise.choose") for key in twice]
    if problems:
        raise InputError(problems)
    return Lattice(tuple(axes))


def _axis(mission: Mission, section: ChoiceSection) -> Axis:
    name = "+".join(section.all_keys)
    if section.choices:
        for key in section.all_keys:
            check_key(mission, key, OPTION)
        if all(NUMBER.fullmatch(str(each)) for each in section.choices):
            return read_axis(mission, f"{name}={','.join(str(each) for each in section.choices)}")
        return Axis(section.all_keys, section.choices, tuple(_label(each) for each in section.choices))
    low, high = _text(section.low), _text(section.high)
    step = _text(section.step) if section.step is not None else _default_step(name, low, high)
    return read_axis(mission, f"{name}={low}:{high}:{step}")


def _text(value: object) -> str:
    return value.isoformat() if isinstance(value, datetime) else str(value)


def _label(value: object) -> str:
    return re.sub(r"[{}'\"]", "", str(value))


def _default_step(name: str, low: str, high: str) -> str:
    """Return a fortieth of the range; of a start, a minute or more."""
    first, last = NUMBER.fullmatch(low), NUMBER.fullmatch(high)
    if name == "start" or first is None or last is None:
        message = f"given from {low} to {high} without a step, expected one"
        raise InputError([Problem(message, key=OPTION, hint="such as step: 10 min")])
    unit = (last[2] or "").strip()
    try:
        begin = parse_number_with_unit(low, unit) if unit else float(first[1])
    except QuantityError as error:
        raise InputError([Problem(str(error), key=OPTION)]) from None
    return f"{(float(last[1]) - begin) / STEPS:.6g} {unit}".strip()
