"""What to choose so that all requirements hold at the least energy or time: a lattice of what may be chosen, as read.

Read then `optimise`, `evaluations` (trials of choices, kept, and how far they are from the requirements) and `search`.
"""

import itertools
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.errors import InputError, KeyPath, Problem, key_path
from missionplan.mission import Mission
from missionplan.mission.documents import Document, load_document
from missionplan.mission.schema.sweep import ChoiceSection
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.results.decision import Axis
from missionplan.studies.exploration import NUMBER, known_key, read_axis, vehicles

Point = tuple[int, ...]
"""A choice: an index along each axis."""


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

    def places(self, points: Sequence[Point]) -> tuple[Array, NDArray[np.intp]]:
        """Return where points lie, shape (n, k), and the axis of each column.

        Numbers run from 0 to 1; of an axis without numbers each value has a column, so that any two are 1 apart.
        """
        columns: list[Array] = []
        axes: list[int] = []
        for number, (axis, indices) in enumerate(zip(self.axes, np.array(points).T, strict=True)):
            values = np.array(axis.numbers if axis.numbers is not None else range(len(axis.values)), dtype=float)
            if axis.numbers is not None:
                columns.append((values[indices] - values.min()) / max(float(np.ptp(values)), 1e-12))
            else:
                columns += [(indices == value) / math.sqrt(2.0) for value in values]
            axes += [number] * (len(columns) - len(axes))
        return np.stack(columns, axis=1), np.array(axes)

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


STEPS = 40
"""Steps between the bounds of a key whose step is not given."""
OPTION = "choose"
_PLACE: KeyPath = ("optimise", "choose")
_EXAMPLE = "optimise: {choose: [{key: ingress.speed, from: 1 m/s, to: 2 m/s}]} in the mission, or --choose"


def read_lattice(mission: Mission, texts: Sequence[str]) -> Lattice:
    """Return what may be chosen: by the options, or else by the mission's section `optimise`.

    Raises InputError with all that is wrong: nothing to choose, keys that the mission does not have, values that they
    cannot take.
    """
    attempts = list(_of_options(mission, texts) if texts else _of_section(mission))
    problems = [problem for attempt in attempts if isinstance(attempt, InputError) for problem in attempt.problems]
    axes = [axis for axis in attempts if isinstance(axis, Axis)]
    if not attempts:
        place = key_path(_PLACE)
        problems.append(Problem("missing; what may be chosen", mission.file, key=place, hint=_EXAMPLE))
    keys = [key for axis in axes for key in axis.keys]
    twice = sorted({key for key in keys if keys.count(key) > 1})
    problems += [Problem(f"{key} is chosen twice", mission.file, key=key_path(_PLACE)) for key in twice]
    if problems:
        raise InputError(problems)
    return Lattice(tuple(axes))


def _of_options(mission: Mission, texts: Sequence[str]) -> Iterator[Axis | InputError]:
    for text in texts:
        try:
            axis = read_axis(mission, text)
            _check_values(mission, axis)
            yield axis
        except InputError as error:
            yield InputError([replace(problem, file="", line=None, key=OPTION) for problem in error.problems])


def _of_section(mission: Mission) -> Iterator[Axis | InputError]:
    for number, section in enumerate(mission.optimise.choose):
        try:
            axis = _axis(mission, section)
            _check_values(mission, axis)
            yield axis
        except InputError as error:
            try:  # the mission's file once more, for its lines, where it is one and still there
                document = load_document(Path(mission.file))
            except InputError:
                document = Document({}, {(): (mission.file, None)})
            place = (*_PLACE, number)
            yield InputError([document.problem(place, problem.message, problem.hint) for problem in error.problems])


def _check_values(mission: Mission, axis: Axis) -> None:
    """Put each value, of numbers the least and the greatest, into the mission alone; raises InputError."""
    problems = []
    ends = (np.argmin(axis.numbers), np.argmax(axis.numbers)) if axis.numbers is not None else range(len(axis.values))
    for index in dict.fromkeys(map(int, ends)):
        values = dict.fromkeys(axis.keys, axis.values[index])
        try:
            mission.with_written(values)
        except InputError as error:
            first = error.problems[0]
            message = f"{axis.name} cannot be {axis.shown(index)}: {first.message}"
            problems.append(Problem(message, key=OPTION, hint=first.hint))
    if problems:
        raise InputError(problems)


def _axis(mission: Mission, section: ChoiceSection) -> Axis:
    name = "+".join(section.all_keys)
    if section.choices:  # of vehicles the names of their files are read
        keys = tuple(known_key(mission, key, OPTION) for key in section.all_keys)
        texts = [str(choice) for choice in section.choices]
        if section.all_keys == ("vehicle",) and all(isinstance(choice, str) for choice in section.choices):
            return vehicles(mission, texts)
        if all(NUMBER.fullmatch(text) for text in texts):
            return read_axis(mission, f"{name}={','.join(texts)}")
        return Axis(keys, section.choices, tuple(re.sub(r"[{}'\"]", "", text) for text in texts))
    low, high = _text(section.low), _text(section.high)
    step = _text(section.step) if section.step is not None else _default_step(name, low, high)
    axis = read_axis(mission, f"{name}={low}:{high}:{step}")
    if axis.numbers is not None and axis.numbers[0] > axis.numbers[-1]:
        raise InputError([Problem(f"from {low} to {high}: expected `from` less than `to`", key=OPTION)])
    return axis


def _text(value: object) -> str:
    return value.isoformat() if isinstance(value, datetime) else str(value)


def _default_step(name: str, low: str, high: str) -> str:
    """Return a fortieth of the range; a start needs a step of its own."""
    first, last = NUMBER.fullmatch(low), NUMBER.fullmatch(high)
    if name == "start" or first is None or last is None:
        message = f"given from {low} to {high} without a step, expected one"
        raise InputError([Problem(message, key=OPTION, hint="such as step: 10 min")])
    unit = (last[2] or "").strip()
    try:
        begin = parse_number_with_unit(low, unit) if unit else float(first[1])
    except QuantityError as error:
        raise InputError([Problem(str(error), key=OPTION)]) from None
    if begin >= float(last[1]):
        raise InputError([Problem(f"from {low} to {high}: expected `from` less than `to`", key=OPTION)])
    return f"{(float(last[1]) - begin) / STEPS:.6g} {unit}".strip()
