"""What was planned, as a report shows it: values of a mission file in words, quantities with their units."""

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path

from missionplan.errors import counted
from missionplan.mission.quantity_paths import values_in_force
from missionplan.mission.units import number_and_unit
from missionplan.report.page import Block, PageSection, Table
from missionplan.report.quantities import (
    DIMENSIONS,
    as_written,
    in_reader_units,
    in_unit_of,
    reader_system,
    reader_unit,
)
from missionplan.report.site_map import site_map
from missionplan.report.wording import capitalised, in_words, set_number
from missionplan.results import Provenance
from missionplan.results.decision import changes_of
from missionplan.results.entries import mapping, mappings

_SIGN = re.compile(r"(?<=\d)\s*deg\b")
"""What the sign of a degree stands for."""
_MOST_CHOICES = 6


def value_in_words(value: object) -> str:
    """Write a value of a mission file: ``10 ± 3 s, at least 0 s``."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Mapping):
        return _distribution(value) or "; ".join(
            f"{in_words(str(key))} {value_in_words(inner)}" for key, inner in value.items()
        )
    if isinstance(value, list | tuple):
        return f"({', '.join(_listed(value))})"
    return _degrees(str(value))


def _listed(values: Sequence[object]) -> Iterator[str]:
    """Write the values of a list: quantities in one unit all in one of the reader's, that of the largest."""
    pairs = [pair for value in values if (pair := number_and_unit(str(value)))]
    unit = pairs[0][1] if len(pairs) == len(values) > 0 and len({unit for _, unit in pairs}) == 1 else None
    if unit not in DIMENSIONS or not reader_system():
        return map(value_in_words, values)
    largest = max(abs(float(number)) for number, _ in pairs)
    return (as_written(number, unit, largest=largest) for number, _ in pairs)


def _degrees(text: str) -> str:
    text = re.sub(r"(?<=\d)\.0+(?= |$)", "", text)
    pair = number_and_unit(text)
    if pair and pair[1] in DIMENSIONS and reader_system():
        return as_written(*pair)
    return _SIGN.sub("°", text)


def _distribution(value: Mapping[str, object]) -> str:
    """Write a distribution; empty for any other mapping."""
    keys = set(value)
    words = {str(key): value_in_words(inner) for key, inner in value.items()}
    if {"mean", "sd"} <= keys <= {"mean", "sd", "low", "high"}:
        bounds = [f", at least {words['low']}"] if "low" in keys else []
        bounds += [f", at most {words['high']}"] if "high" in keys else []
        return _joined(words["mean"], "±", words["sd"]) + "".join(bounds)
    if keys == {"low", "high"}:
        return _joined(words["low"], "to", words["high"])
    if keys == {"median", "factor"}:
        return f"{words['median']}, × or ÷ {words['factor']}"
    choices = value.get("choices")
    if keys == {"choices"} and isinstance(choices, list | tuple):
        listed = [value_in_words(choice) for choice in choices]
        if len(listed) > _MOST_CHOICES:
            return f"one of {len(listed)} values, from {listed[0]} to {listed[-1]}"
        return " or ".join(listed)
    return ""


def _joined(first: str, sign: str, second: str) -> str:
    """Join two quantities; a unit that both have is written once."""
    one, two = number_and_unit(first), number_and_unit(second)
    if one is None or two is None or one[1] != two[1]:
        return f"{first} {sign} {second}"
    (number, unit), (other, _) = one, two
    is_small = "e" in f"{number}{other}".lower()  # powers of ten have as many digits as they need
    decimals, wanted = (0 if is_small else len(text.partition(".")[2]) for text in (number, other))
    if sign == "±" and decimals > wanted:  # no error bears more digits than it has itself
        return f"{first}, sd {second}"
    if sign == "±" and decimals < wanted:
        number = f"{float(number):.{wanted}f}"
    return f"{number} {sign} {other}{'' if unit in ('°', '') else ' '}{unit}"


Row = tuple[str, str]
"""What it is, and its value."""

_NAMES = {
    "from": "from",
    "to": "to",
    "depth": "at a depth of",
    "speed": "at",
    "d_max": "legs of at most",
    "arrival_radius": "arrived within",
    "radius": "anchor within",
    "anchor_wet_weight": "anchor",
    "line_length": "line",
    "release_time": "separates after",
    "hold": "holds",
    "galvanic_release": "released after",
    "drift_compensation": "correction for the drift",
    "fix_error": "error of a fix, sd of each axis",
    "surfacing_time": "surfacing for a fix takes",
    "sigma": "velocity error of a leg, sd of each axis",
    "covariance": "covariance of a leg's velocity error",
    "origin": "origin of the coordinates",
    "mass": "dry mass",
    "roughness": "roughness of the seafloor",
}
"""Keys that say more in other words."""
_VEHICLE = ("name", "hull", "mass", "net_buoyancy", "line", "anchor")
_ANCHOR = ("diameter", "drag_coefficient", "holding_factor", "flooding_time", "flooded_mass")
"""Keys of the vehicle and of its anchor that are shown; the file has the others."""


def planned_sections(provenance: Provenance, *, mapped: bool = False) -> list[PageSection]:
    """Show what was planned, for a result of one mission, and what the answer rests on.

    On a page that is `mapped`, with a map of the mission, one of the site only adds its chart.
    """
    data = provenance.data
    if not isinstance(data.get("phases"), list | tuple):
        return where_checked(provenance)
    rows = [*_site(data), *_vehicle(data), *_phases(data), *_effects(data)]
    table = Table(
        ("", ""),
        [(capitalised(name), value) for name, value in rows],
        "± is one standard deviation. The mission file, at the end of this page and in mission.yaml, has it all.",
        text_columns=2,
    )
    drawn = None if mapped and "chart" not in mapping(data.get("site")) else site_map(data)
    blocks: list[Block] = [*([drawn] if drawn else []), *([table] if rows else [])]
    heading = "The starter mission" if provenance.command == "import" else "What was planned"
    planned = [PageSection(heading, blocks, is_summary=provenance.command == "import")] if blocks else []
    return [*not_held(provenance), *planned, *where_checked(provenance)]


_OF_NO_MISSION = ("diagnose", "score", "sweep-transition")
"""Commands whose answer is not whether a mission succeeds, which may fail of more."""


def not_held(provenance: Provenance) -> list[PageSection]:
    """Show what an answer holds of the world, and what not."""
    if not provenance.holds or provenance.command in _OF_NO_MISSION:
        return []
    rows = [(aspect.what, in_reader_units(aspect.why)) for aspect in provenance.holds if not aspect.held]
    reasons = [f"{aspect.what} ({in_reader_units(aspect.why)})" for aspect in provenance.holds if aspect.held]
    blocks: list[Block] = [Table(("", ""), rows, text_columns=2)] if rows else []
    blocks += [f"It holds {'; '.join(reasons)}."] if reasons else []
    return [PageSection("What this answer does not hold", blocks, is_summary=True)]


def changed(data: Mapping[str, object], values: Mapping[str, object]) -> list[PageSection]:
    """Show which keys of the mission a result would have changed: was and now; nothing where it changes none."""
    rows = [
        (change.key, _table_or_value(change.was), f"{_table_or_value(change.now)}{in_unit_of(change.was, change.now)}")
        for change in changes_of(data, values)
    ]
    table = Table(("key", "was", "now"), rows, text_columns=3)
    return [PageSection("What changes in the mission", [table], is_summary=True)] if rows else []


def _table_or_value(value: object) -> str:
    if value is None:
        return "not given"
    table = mapping(value).get("table")
    return f"a table of {counted(len(table), 'row')}" if isinstance(table, list | tuple) else value_in_words(value)


def where_checked(provenance: Provenance) -> list[PageSection]:
    """Show on which rows of the validation the answer rests, and whether the mission is in the ranges checked."""
    if not provenance.rests_on:
        return []
    outside = [check.quantity for check in provenance.checked if not check.is_inside]
    rows = [
        (
            check.quantity,
            _from_to(check.least, check.greatest, check.unit),
            _from_to(check.low, check.high, check.unit),
            "inside" if check.is_inside else "outside",
        )
        for check in provenance.checked
    ]
    heading = "Where the model was checked"
    if provenance.checked:
        heading += f": outside for {', '.join(outside)}" if outside else ", with this mission inside"
    listed = f"It rests on these rows of docs/validation: {', '.join(provenance.rests_on)}."
    caption = f"At the means. Outside a range nothing is known to be wrong; nothing was compared there. {listed}"
    table = Table(("", "this mission", "checked", ""), rows, caption, text_columns=4)
    return [PageSection(heading, [table if rows else listed])]


def _from_to(low: float, high: float, unit: str) -> str:
    shown = reader_unit(unit, max(abs(low), abs(high)))
    rounded = dict.fromkeys(f"{float(f'{shown(value):.3g}'):g}" for value in (low, high))
    return " to ".join(_SIGN.sub("°", f"{set_number(number)}{shown.suffix}") for number in rounded)


def _named(key: str) -> str:
    return _NAMES.get(key, in_words(key))


def _site(data: Mapping[str, object]) -> Iterator[Row]:
    """Write the site, then the navigation."""
    for key, value in mapping(data.get("site")).items():
        if key == "current":
            yield from _current(value)
        elif key == "chart":
            yield "chart", Path(str(value)).name
        elif key == "depth":
            yield "depth of the water", value_in_words(value)
        elif isinstance(value, Mapping) and isinstance(value.get("file"), str):
            yield _named(key), value_in_words({**value, "file": Path(value["file"]).name})
        else:
            yield _named(key), value_in_words(value)
    for key, value in mapping(data.get("navigation")).items():
        if key == "velocity_error":
            for inner, spread in mapping(value).items():
                name = "mean velocity error, east and north" if inner == "mean" else _named(inner)
                yield name, value_in_words(spread)
        else:
            yield _named(key), value_in_words(value)


def _current(value: object) -> Iterator[Row]:
    """Write each layer of a current, or where it is read."""
    if not isinstance(value, list | tuple):
        yield "current", _recorded(value)
        return
    above = "surface"
    for layer in map(mapping, value):
        edge = value_in_words(layer.get("down_to"))
        words = f"{value_in_words(layer.get('speed'))} toward {value_in_words(layer.get('toward'))}"
        yield f"current, {above} to {edge}", words
        above = edge


def _recorded(current: object) -> str:
    """Write the file of a recorded current without its folder, or those of an ensemble with their weights."""
    if not isinstance(current, Mapping):
        return value_in_words(current)
    file, rest = current.get("file"), {key: value for key, value in current.items() if key not in ("file", "weights")}
    weights = current.get("weights")
    files = [Path(str(member)).name for member in file] if isinstance(file, list | tuple) else [Path(str(file)).name]
    if isinstance(weights, list | tuple) and len(weights) == len(files):
        files = [f"{name} (weight {value_in_words(weight)})" for name, weight in zip(files, weights, strict=True)]
    words = f"one of {len(files)} files: {', '.join(files)}" if len(files) > 1 else f"file {files[0]}"
    return "; ".join(filter(None, (words, value_in_words(rest))))


def _vehicle(data: Mapping[str, object]) -> Iterator[Row]:
    vehicle = mapping(data.get("vehicle"))
    for key in (key for key in _VEHICLE if key in vehicle):
        value = vehicle[key]
        if key == "name":
            yield "vehicle", str(value)
        elif key == "anchor":
            shown = {inner: content for inner, content in mapping(value).items() if inner in _ANCHOR}
            if shown:
                yield "anchor", value_in_words(shown)
        elif key in ("mass", "net_buoyancy") and "anchor" in vehicle:
            yield f"{_named(key)} without the anchor", value_in_words(value)
        elif key == "hull":
            hull = mapping(value)
            author = hull.get("form_factor")
            named = {**hull, "form_factor": f"after {author.capitalize()}"} if isinstance(author, str) else hull
            yield "hull", value_in_words(named)
        else:
            yield _named(key), value_in_words(value)
    # what is in force of the keys that mission and vehicle may both give, and where it is from
    for setting in values_in_force(data):
        words = "none" if setting.value is None else value_in_words(setting.value)
        instead = "" if setting.overridden is None else f", not the vehicle's {value_in_words(setting.overridden)}"
        yield in_words(".".join(map(str, setting.path))), f"{words} ({setting.source}{instead})"


def _phases(data: Mapping[str, object]) -> Iterator[Row]:
    for kind, section in _items(data["phases"]):
        words = []
        for key, value in mapping(section).items():
            if isinstance(value, bool):
                words.append(f"{'with' if value else 'without'} {_named(key)}")
            elif key == "d_max" and isinstance(value, Mapping) and "table" in value:
                words.append("legs from a table")
            elif key not in ("name", "sweep"):
                words.append(f"{_named(key)} {value_in_words(value)}")
        name = str(mapping(section).get("name", kind))
        yield name if name == kind else f"{name} ({kind})", ", ".join(words)


def _effects(data: Mapping[str, object]) -> Iterator[Row]:
    """Write the effects that the mission states, and what its draws say of each, as their summary has it."""
    for name, parameters in _items(data.get("effects")):
        if name != "one-of" or not isinstance(parameters, list | tuple):
            yield f"effect: {name.replace('-', ' ')}", value_in_words(parameters) if parameters else "as usual"
            continue
        for explanation in map(mapping, parameters):
            parts = [
                f"{effect.replace('-', ' ')} ({value_in_words(sizes)})" if sizes else effect.replace("-", " ")
                for effect, sizes in _items(explanation.get("effects"))
            ]
            share = explanation.get("probability")
            yield f"possible, {_share(share) if isinstance(share, int | float) else 'an explanation'}", ", ".join(parts)
    for name, summary in mapping(mapping(data.get("posterior")).get("summary")).items():
        sizes = {key: value for key, value in mapping(summary).items() if key != "probability"}
        share = mapping(summary).get("probability")
        if isinstance(share, int | float):
            yield f"learned: {name.replace('-', ' ')}, {_share(share)}", value_in_words(sizes)


def _share(probability: float) -> str:
    return f"{100.0 * probability:.3g} %"


def _items(entries: object) -> Iterator[tuple[str, object]]:
    """Names and contents of a list of mappings, as phases and effects are."""
    return chain.from_iterable(entry.items() for entry in mappings(entries))
