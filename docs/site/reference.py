"""The reference: commands, keys, effects, summaries and functions, each from what the program itself knows."""

import inspect
import json
import math
import re
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

import typer
from pydantic import BaseModel
from pydantic.fields import FieldInfo

import missionplan
from missionplan.cli import app
from missionplan.datasets.dives import DESCENT
from missionplan.datasets.legs import TRANSIT
from missionplan.datasets.summaries import SUMMARY
from missionplan.datasets.tank import TANK_FORMATS
from missionplan.effects import CATALOGUE
from missionplan.exporters import conformance_table
from missionplan.mission import Mission
from missionplan.mission.schema.quantity_parser import Limit, QuantityParser
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.mission.validation_errors import keys_of, meaning_of, parsers_of, sections_in
from missionplan.report.effect_catalogue import effect_text

ROOT = Path(__file__).parents[2]


def pages() -> dict[str, str]:
    """Return the pages of the reference by path."""
    return {
        "reference/commands.md": _commands(),
        "reference/effects.md": _effects(),
        "reference/formats.md": _formats(),
        "reference/keys.md": _keys(),
        "reference/python.md": _functions(),
        "reference/summaries.md": _summaries(),
    }


def _commands() -> str:
    group = typer.main.get_command(app)
    parts = [
        "# Commands\n",
        "Exit status: 0 done, 1 failed, 2 bad input, 3 done but a requirement is not met, 130 interrupted.\n",
    ]
    for name, command in sorted(group.commands.items()):  # type: ignore[attr-defined]  # it is a group
        context = command.make_context(f"missionplan {name}", [], resilient_parsing=True)
        usage = " ".join(command.collect_usage_pieces(context))
        parts += [f"## {name}\n", (command.help or "").strip() + "\n", f"```text\nmissionplan {name} {usage}\n```\n"]
        given = command.get_params(context)
        rows = [
            (str(each.metavar or each.name), getattr(each, "help", "") or "")
            for each in given
            if each.param_type_name == "argument"
        ]
        rows += [record for each in given if (record := each.get_help_record(context)) and record[0].startswith("-")]
        parts += ["| argument or option | meaning |", "|---|---|"]
        parts += [f"| `{_cell(option)}` | {_cell(meaning)} |" for option, meaning in dict(rows).items()]
        parts.append("")
    return "\n".join(parts)


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def _keys() -> str:
    parts = [
        "# Keys\n",
        "Every key of the files that are read, from the schema that checks them. Where a quantity stands, a "
        "distribution may stand too, unless the key is fixed ([mission files](../mission-files.md)). Beyond "
        "the possible is an error, beyond the usual a notice.\n",
    ]
    for title, model in (("Mission", Mission), ("Vehicle", Vehicle)):
        parts += [f"## {title}\n", *_table(model)]
    for form in (TRANSIT, DESCENT, SUMMARY, *TANK_FORMATS.values()):
        columns = [", ".join(f"`{name}`" for name in names) for names in form.columns.alternatives]
        more = ", ".join(f"`{name}`" for name in form.columns.optional)
        parts += [
            f"## Data set: {form.kind}\n",
            f"Columns of its CSV: {'; or '.join(columns)}.{f' It may have {more}.' if more else ''}\n",
            *_table(form.settings),
        ]
    return "\n".join(parts)


def _table(model: type[BaseModel]) -> list[str]:
    rows = [f"| `{path}` | {' | '.join(map(_cell, words))} |" for path, *words in _fields(model, "")]
    return ["| key | meaning | expected | possible; usual | default |", "|---|---|---|---|---|", *rows, ""]


def _fields(model: type[BaseModel], path: str) -> Iterator[tuple[str, str, str, str, str]]:
    for name, field in keys_of(model).items():
        here = f"{path}.{name}" if path else name
        inner = list(sections_in(field.annotation))
        if name == "effects":
            yield here, "", "a list of effects ([Effects](effects.md))", "", ""
            continue
        quantities = dict.fromkeys(_expected(parser) for parser in parsers_of(field))
        if name == "vehicle":
            yield here, "", "a vehicle, or the name of its file", "", ""
            continue
        words = ", or ".join([*quantities, *(["a section"] if inner else [])]) or _kind(field.annotation)
        plain = not field.is_required() and field.default not in (None, (), "") and not inner
        meaning = meaning_of(field) or " ".join(dict.fromkeys(map(_words_of, inner)))
        yield here, meaning, words, _limits(field), f"`{field.default}`" if plain else ""
        listed = "[]" if "tuple" in str(field.annotation) else ""
        for section in inner:
            yield from _fields(section, here + listed)


def _words_of(section: type[BaseModel]) -> str:
    """What a section says of itself and of keys that have no words of their own, but for lists of attributes."""
    words = inspect.getdoc(section) or ""
    return re.split(r"\n\w+\n-+\n", words)[0].replace("``", "`")


def _limits(field: FieldInfo) -> str:
    """What is possible and what is usual, in the field's unit or the limit's own, and who says so."""
    limit = next((each for each in field.metadata if isinstance(each, Limit)), None)
    if limit is None:
        return ""
    unit = limit.unit if limit.unit is not None else parsers_of(field)[0].unit
    possible, usual = (
        f"{low:g} to {high:g}".replace(" to inf", " or more") for low, high in (limit.possible, limit.usual)
    )
    size = " either way" if limit.signed else ""
    return f"{possible}; {usual} {unit}{size} ({limit.source})"


def _expected(parser: QuantityParser) -> str:
    low = "" if parser.low == -math.inf else f", {'more than' if parser.open_low else 'at least'} {parser.low:g}"
    high = "" if parser.high == math.inf else f", at most {parser.high:g}"
    return f"{parser.expected}{low}{high}{', fixed' if parser.fixed else ''}"


def _kind(annotation: object) -> str:
    words = str(annotation)
    if "Literal[" in words:
        return words.partition("Literal[")[2].partition("]")[0].replace("'", "`")
    kinds = {"datetime": "a time (ISO 8601, UTC)", "bool": "true or false", "int": "a whole number", "str": "text"}
    return next((shown for kind, shown in kinds.items() if kind in words), "see the text")


def _effects() -> str:
    parts = ["# Effects\n", "What `missionplan effects ID` says of each.\n"]
    for name in sorted(CATALOGUE):
        parts += [f"## {name}\n", f"```text\n{effect_text(CATALOGUE[name]).rstrip()}\n```\n"]
    return "\n".join(parts)


def _formats() -> str:
    words = "What the format of each vehicle keeps of the guards that lead from one state of a plan to the next"
    return f"# Formats of plans\n\n{words} ([vehicles](../vehicles.md)).\n\n{conformance_table()}"


def _functions() -> str:
    parts = [
        "# Python\n",
        "Every command is a function of `missionplan`; each takes a mission or the path of its file.\n",
    ]
    modules = missionplan._MODULES  # where each name is defined
    for name in sorted(modules):
        parts.append(f"::: {modules[name]}.{name}\n" if name != "Mission" else "")
    options = "    options:\n      members: true\n      filters: ['!^_', '!^model_']\n"
    parts.append(f"::: missionplan.mission.mission.Mission\n{options}")
    return "\n".join(parts)


def _summaries() -> str:
    """Run small studies of the shipped missions and list what their summaries hold."""
    missions = ROOT / "missions"
    made = {
        "simulate": lambda: missionplan.simulate(missions / "fig8.yaml", trials=200, seed=1),
        "sweep-dmax": lambda: missionplan.sweep_dmax(missions / "fig8.yaml", trials=50, seed=1),
        "size-anchor": lambda: missionplan.size_anchor(missions / "anchor-design.yaml", trials=50, seed=1),
        "identify": lambda: missionplan.identify(missions / "measured" / "avila-drag"),
        "diagnose": _diagnosed,
    }
    parts = ["# Summaries\n", "Keys of `summary.json`; they end with the unit. A list is shown by its first item.\n"]
    for command, run in made.items():
        summary = json.loads(json.dumps(run().summary(), default=str))
        parts += [f"## {command}\n", "| key | for example |\n|---|---|"]
        parts += [f"| `{key}` | {_cell(str(value))[:60]} |" for key, value in _flat(summary)]
        parts.append("")
    return "\n".join(parts)


def _diagnosed() -> object:
    with tempfile.TemporaryDirectory() as folder:
        missionplan.init(folder)
        return missionplan.diagnose(Path(folder) / "mission.yaml", Path(folder) / "sea-trial", plan=False)


def _flat(value: object, path: str = "") -> Iterator[tuple[str, object]]:
    if isinstance(value, Mapping) and value:
        for key, inner in value.items():
            yield from _flat(inner, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list) and value:
        yield from _flat(value[0], f"{path}[]")
    else:
        yield path, value
