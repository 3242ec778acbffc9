"""When to go and what to choose: keys that are varied, read as people write them, and put in their places.

Read then `explore`, `cells` (one cell) and `result` (the best cells, and where the requirements are met).
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path

import yaml
from pydantic import BaseModel

from missionplan.errors import InputError, Problem, attempted, did_you_mean, shown
from missionplan.mission import Mission
from missionplan.mission.changes import UnclearKeyError, find_key, value_at
from missionplan.mission.documents import load_document
from missionplan.mission.quantity_paths import name_in_force, overridden, resolved_path
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.moments import moment_of
from missionplan.results.decision import Axis

_STEP = re.compile(r"[^.\[\]]+|\[\d+\]")
_WHOLES = ("vehicle", "start", "site.current", "site.water", "vehicle.anchor")
"""Keys that may be varied as a whole, besides those that hold one value."""
_OF_THE_RUN = (
    *("schema", "file_schema", "monte_carlo", "sweep", "optimise", "requirements", "correlations"),
    *("posterior", "learned_from", "units", "name"),
)
"""Sections that no choice of a mission can lie in."""


def known_key(mission: Mission, key: str, option: str) -> str:
    """Return the key path of a key that a person writes, with what stands for its phase.

    `option`: how messages name the place where the key stands. Raises InputError with the nearest key.
    """
    if _STEP.findall(key)[:1] in [[name] for name in _OF_THE_RUN]:
        raise InputError([Problem(f"given the key {shown(key)}, which says how the mission is computed", key=option)])
    if overridden(tuple(key.split(".")), mission.raw):
        said = name_in_force(key)
        message = f"given the key {shown(key)}, which changes nothing: the mission's own {said} goes before it"
        raise InputError([Problem(message, key=option, hint=f"did you mean {said}?")])
    keys, key = known_keys(mission), resolved_path(key, [phase.label for phase in mission.phases])
    if key in keys or _is_written(mission.raw, key):
        return key
    hint = did_you_mean(key, keys) or "such as start, ingress.speed, moor.line_length: key paths, phases by name"
    raise InputError([Problem(f"given the key {shown(key)}, which the mission does not have", key=option, hint=hint)])


def known_keys(mission: Mission) -> set[str]:
    """Return the key paths of a mission that hold one value each, given or not, phases by name."""
    keys = set(_WHOLES)
    for name, value in mission:
        if name == "entries":
            for phase in mission.phases:
                _collect(phase, phase.name, keys)
        elif name == "effect_list":
            keys |= {path for entry in mission.effects for path in entry.names}
        elif name not in _OF_THE_RUN:
            _collect(value, name, keys)
    return keys | {".".join(map(str, value.path)) for value in mission.values_in_force()}


def _collect(value: object, path: str, keys: set[str]) -> None:
    if isinstance(value, BaseModel):
        fields = type(value).model_fields
        for name, inner in value:
            if not fields[name].exclude:
                _collect(inner, f"{path}.{fields[name].alias or name}", keys)
    elif isinstance(value, tuple) and any(isinstance(inner, BaseModel) for inner in value):
        for index, inner in enumerate(value):
            _collect(inner, f"{path}[{index}]", keys)
    else:
        keys.add(path)


def _is_written(data: Mapping[str, object], key: str) -> bool:
    """Whether the mission's file has something at a path."""
    try:
        return all(value_at(data, path) is not None for path in find_key(key, data, Mission))
    except UnclearKeyError:
        return False


MAX_CELLS = 5000
OPTION = "vary"
NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\d\s:].*?)?\s*")
_CLOCK = re.compile(r"\s*\d{1,2}:\d{2}(?::\d{2})?\s*")
_EXAMPLE = "such as ingress.speed=0.8:2:0.1 m/s, start=04:00:12:00:10 min or vehicle=a.yaml,b.yaml"


def read_axes(mission: Mission, texts: Sequence[str]) -> tuple[Axis, ...]:
    """Read one or two variations.

    `texts`: ``KEY=FROM:TO:STEP`` in the units of the mission file (a bare number takes the unit of the next), or
    ``KEY=A,B,C``. ``KEY+KEY=…`` gives several keys the same values. Times of `start` are ISO 8601, or a time of the
    mission's day, or a duration after the mission's own start. Raises InputError with the first that is wrong in each.
    """
    if not 1 <= len(texts) <= 2:
        raise InputError([Problem(f"given {len(texts)} times, expected once or twice", key=OPTION, hint=_EXAMPLE)])
    problems: list[Problem] = []
    attempts = [attempted(partial(read_axis, mission, text), problems) for text in texts]
    axes = [axis for axis in attempts if axis is not None]
    cells = math.prod(len(axis.values) for axis in axes)
    if not problems and cells > MAX_CELLS:
        problems.append(Problem(f"makes {cells} cells, expected at most {MAX_CELLS}", key=OPTION))
    if len(axes) == 2 and set(axes[0].keys) & set(axes[1].keys):
        problems.append(Problem(f"varies {axes[0].name} twice", key=OPTION))
    if problems:
        raise InputError(problems)
    return tuple(axes)


def read_axis(mission: Mission, text: str) -> Axis:
    """Read one variation; see `read_axes`."""
    name, equals, values = (part.strip() for part in text.partition("="))
    if not equals or not values:
        raise _wrong(f"given {shown(text)}, expected KEY=FROM:TO:STEP or KEY=A,B,C", _EXAMPLE)
    keys = tuple(known_key(mission, key.strip(), OPTION) for key in name.split("+"))
    if keys == ("start",):
        return _times(mission, values)
    if keys == ("vehicle",):
        return vehicles(mission, values.split(","))
    ranged = ":" in values
    parts = [part.strip() for part in values.split(":" if ranged else ",")]
    matches = [match for part in parts if (match := NUMBER.fullmatch(part))]
    if ranged and not len(matches) == len(parts) == 3:
        raise _wrong(f"given {shown(values)}, expected FROM:TO:STEP, numbers with units", _EXAMPLE)
    if len(matches) < len(parts):  # whatever YAML takes them for
        return Axis(keys, tuple(yaml.safe_load(part) for part in parts), tuple(parts))
    return _axis(keys, matches, ranged=ranged)


def _axis(keys: tuple[str, ...], matches: Sequence["re.Match[str]"], *, ranged: bool) -> Axis:
    """Return an axis of numbers, or of a range, in the unit of the last; a bare one takes the unit of the next.

    Values are as the mission file takes them: bare whole numbers stay whole.
    """
    unit = last = (matches[-1][2] or "").strip()
    numbers: list[float] = []
    for match in reversed(matches):
        last = (match[2] or last).strip()
        try:
            numbers.append(float(match[1]) if last == unit else parse_number_with_unit(f"{match[1]} {last}", unit))
        except QuantityError as error:
            raise _wrong(str(error)) from None
    numbers = steps(*numbers[::-1]) if ranged else numbers[::-1]
    texts = [f"{number:.10g}" for number in numbers]
    values: tuple[object, ...] = tuple(f"{text} {unit}" for text in texts)
    if not unit:
        values = tuple(int(number) if float(number).is_integer() else float(number) for number in numbers)
    return Axis(keys, values, tuple(texts), tuple(float(text) for text in texts), unit)


def steps(first: float, last: float, step: float) -> list[float]:
    """Return the numbers from the first in steps, to the last where a step meets it."""
    if not all(map(math.isfinite, (first, last, step, last - first))):
        raise _wrong(f"given steps of {step:g} from {first:g} to {last:g}, expected numbers that a computer can hold")
    if step == 0.0 or (last - first) / step < 0.0:
        raise _wrong(f"steps of {step:g} never lead from {first:g} to {last:g}")
    count = math.floor(min((last - first) / step + 1e-9, 1e15))
    if count >= MAX_CELLS:
        raise _wrong(f"makes {count + 1} cells, expected at most {MAX_CELLS}")
    return [first + index * step for index in range(count + 1)]


def _times(mission: Mission, values: str) -> Axis:
    """Read starts: ``FROM:TO:STEP``, whose times have colons themselves, or a list of times."""
    if mission.start is None:
        raise _wrong("varies `start`, but the mission has none: what a time means must be known")
    if "," in values or values.count(":") < 2:
        moments = [_moment(mission.start, part.strip()) for part in values.split(",")]
        if None in moments:
            raise _wrong(f"given {shown(values)}, expected times, such as 04:00,05:30 or 2026-06-01T04:00")
        return _starts([moment for moment in moments if moment is not None])
    for begin, end, step in _ranges_of_times(mission.start, values.split(":")):
        if end < begin < begin + timedelta(seconds=step):
            raise _wrong(f"given {shown(values)}: the last time is before the first")
        seconds = steps(0.0, (end - begin).total_seconds(), step)
        return _starts([begin + timedelta(seconds=offset) for offset in seconds])
    raise _wrong(
        f"given {shown(values)}, expected FROM:TO:STEP", "such as start=04:00:12:00:10 min or =0 h:12 h:15 min"
    )


def _ranges_of_times(base: datetime, parts: list[str]) -> Iterator[tuple[datetime, datetime, float]]:
    """Yield every way to read parts between colons as first time, last time and step [s]; the likeliest first."""
    for second in range(len(parts) - 1, 1, -1):  # the last colon is that before the step
        step = _seconds(":".join(parts[second:]))
        for first in range(1, second):
            begin, end = (_moment(base, ":".join(part)) for part in (parts[:first], parts[first:second]))
            alike = len(parts[:first]) == len(parts[first:second])
            if step is not None and begin is not None and end is not None and alike:
                yield begin, end, step


def _moment(base: datetime, text: str) -> datetime | None:
    """Return a time: ISO 8601 (UTC unless it says), a time of the mission's day, or a duration after its start."""
    try:
        if _CLOCK.fullmatch(text):
            hour, minute, *rest = (int(part) for part in text.split(":"))
            return base.replace(hour=hour, minute=minute, second=rest[0] if rest else 0, microsecond=0)
        if (after := _seconds(text)) is not None:
            return base + timedelta(seconds=after)
        return moment_of(text)
    except (ValueError, OverflowError):
        return None


def _seconds(text: str) -> float | None:
    try:
        return parse_number_with_unit(text.strip(), "s")
    except QuantityError:
        return None


def _starts(moments: Sequence[datetime]) -> Axis:
    values = tuple(moment.isoformat() for moment in moments)
    one_day = len({moment.date() for moment in moments}) == 1
    labels = tuple(f"{moment:%H:%M}" if one_day else f"{moment:%d %b %H:%M}" for moment in moments)
    return Axis(("start",), values, labels, tuple(moment.timestamp() for moment in moments), "UTC")


def vehicles(mission: Mission, names: Sequence[str]) -> Axis:
    """Read vehicle files, relative to the working directory or else to the mission's folder."""
    folder, documents = Path(mission.file).parent, []
    problems: list[Problem] = []
    paths = [Path(name.strip()) if Path(name.strip()).exists() else folder / name.strip() for name in names]
    for path in paths:
        try:
            documents.append(load_document(path, str(path)).data)
        except InputError as error:
            problems += [
                replace(problem, message=f"{path}: {problem.message}", file="", key=OPTION)
                for problem in error.problems
            ]
    if problems:
        raise InputError(problems)
    return Axis(("vehicle",), tuple(documents), tuple(path.stem for path in paths))


def _wrong(message: str, hint: str = "") -> InputError:
    return InputError([Problem(message, key=OPTION, hint=hint)])


def first_start(axes: Sequence[Axis]) -> datetime | None:
    """Return the earliest start along some axes; None where the start is not varied."""
    moments = [number for axis in axes if axis.is_time and axis.numbers for number in axis.numbers]
    return datetime.fromtimestamp(min(moments), UTC) if moments else None
