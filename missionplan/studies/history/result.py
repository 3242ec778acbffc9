"""What was learned of each parameter, from mission to mission, and failure rates by the counts of a fleet."""

import csv
import io
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Literal, get_args

import pandas as pd
import yaml

from missionplan.errors import InputError, Problem, did_you_mean, shown
from missionplan.identity import digest_of
from missionplan.mission import Mission
from missionplan.mission.documents import read_text
from missionplan.mission.schema.vehicle import Hazard, Leaves, Per
from missionplan.montecarlo.distributions import Quantity, mean_of, sd_of
from missionplan.montecarlo.reliability import chance_of_counts, counts_of_rate, rate_quantile
from missionplan.results import Provenance, Result, to_csv, to_json
from missionplan.results.entries import Entry, Record, mapping, mappings, stated
from missionplan.results.learned.levels import ParameterLevels

State = Literal["found", "confirmed", "changed"]
"""Whether a parameter is new to the mission, as the mission knew it, or not so."""


@dataclass(frozen=True)
class Learned(Record):
    """What one diagnosis says of one parameter."""

    report: Annotated[str, Entry("its folder, below that of the history")]
    mission: Annotated[str, Entry("the mission's name")]
    dataset: Annotated[str, Entry("the data set's name")]
    time: Annotated[str, Entry("of its data, its mission's start or when it was made, as ``ordered_by`` says (UTC)")]
    effect: Annotated[str, Entry("whose parameter it is")]
    name: Annotated[str, Entry("of the parameter")]
    value: Annotated[float, Entry("of the parameter, in its unit")]
    sd: Annotated[float, Entry("standard deviation")]
    low: Annotated[float, Entry("lower end of the 90 % interval")]
    high: Annotated[float, Entry("upper end of the 90 % interval")]
    unit: Annotated[str, Entry("of the parameter")]
    state: Annotated[State, Entry("whether it is new to the mission, as the mission knew it, or not so")]
    probability: Annotated[
        float, Entry("that the explanation holds in which it was found; 1 where the diagnosis left no doubt")
    ] = 1.0

    @property
    def key(self) -> tuple[str, str]:
        """Effect and name of the parameter."""
        return self.effect, self.name

    @property
    def is_change(self) -> Annotated[bool, Entry(key="changed")]:
        """Whether the vehicle or the water was no longer as before: the diagnosis says so, or the level jumped."""
        return self.state == "changed"


_VALUES = "report", "time", "value", "sd", "low", "high", "state", "probability", "changed"


@dataclass(frozen=True)
class LearnedParameter(Record):
    """What was learned of one parameter, in the order of time."""

    effect: Annotated[str, Entry("whose parameter it is")]
    name: Annotated[str, Entry("of the parameter")]
    values: Annotated[list[Learned], Entry("what each diagnosis says", parts=_VALUES)]

    @property
    def unit(self) -> Annotated[str, Entry()]:
        """Unit of the values."""
        return self.values[-1].unit


@dataclass(frozen=True)
class FailureRate(Record):
    """Rate of a hazard of the vehicle's equipment, with the counts of a fleet in it."""

    per: Annotated[str, Entry("what it counts by")]
    leaves: Annotated[str, Entry("what its failures leave of the vehicle; empty for the default")]
    failures: Annotated[float, Entry("of the fleet that are new to the mission")]
    exposure: Annotated[float, Entry("hours, kilometres or events in which they were")]
    prior: Annotated[
        str,
        Entry("in which form the mission holds the rate; ``fixed`` and ``Weibull`` laws are not updated but replaced"),
    ]
    prior_failures: Annotated[float, Entry("that the mission's rate is worth")]
    prior_exposure: Annotated[float, Entry("likewise")]
    rate: Annotated[float, Entry("mean, per hour, kilometre or event")]
    low: Annotated[float, Entry("lower end of its 90 % interval")]
    high: Annotated[float, Entry("upper end of its 90 % interval")]
    surprise: Annotated[float, Entry("probability of counts as far out, by the mission's rate; 1 where it has none")]
    learned_from: Annotated[tuple[str, ...], Entry("hashes of the rows counted, those before among them")]

    @property
    def unit(self) -> Annotated[str, Entry()]:
        """Unit of the exposure."""
        return {"hour": "h", "km": "km"}.get(self.per, self.per + "s" * (self.exposure != 1.0))


@dataclass(frozen=True)
class History(Result):
    """Learned parameters from mission to mission, and failure rates of a fleet."""

    report: ClassVar[str] = "missionplan.studies.history.page"

    provenance: Provenance
    reports: Annotated[tuple[str, ...], Entry("diagnoses, in the order of time")]
    entries: tuple[Learned, ...]
    """In the order of time."""
    ordered_by: Annotated[
        str, Entry("times: date of the ``data``, ``start`` of the missions, or when the reports were ``created``")
    ]
    levels: Annotated[tuple[ParameterLevels, ...], Entry("how parameters of the vehicle go", optional=True)] = ()
    rates: Annotated[tuple[FailureRate, ...], Entry("failure rates, where the folder has counts", optional=True)] = ()
    rates_file: str = ""
    """`reliability.yaml`; empty without counts."""

    @property
    def parameters(self) -> dict[tuple[str, str], list[Learned]]:
        """What was learned of each parameter, in the order of time."""
        by_key: dict[tuple[str, str], list[Learned]] = {}
        for entry in self.entries:
            by_key.setdefault(entry.key, []).append(entry)
        return by_key

    @property
    def changes(self) -> list[Learned]:
        """Where a parameter was no longer as before."""
        return [entry for entry in self.entries if entry.is_change]

    @property
    def values(self) -> Annotated[list[LearnedParameter], Entry(key="parameters")]:
        """What was learned of each parameter."""
        return [LearnedParameter(*key, entries) for key, entries in self.parameters.items()]

    def to_frame(self) -> pd.DataFrame:
        """One row for what each diagnosis says of each parameter."""
        columns = [entry.key for entry in stated(Learned)]
        return pd.DataFrame([entry.row() for entry in self.entries], columns=columns)

    def files(self) -> dict[str, str | bytes]:
        """``history.csv``, ``history.json``, and ``reliability.yaml`` where failures were counted."""
        contents: dict[str, str | bytes] = {
            "history.csv": to_csv(self.to_frame()),
            "history.json": to_json(self.summary()),
        }
        return contents | ({"reliability.yaml": self.rates_file} if self.rates_file else {})


FILE = "reliability.csv"
COLUMNS = ("per", "failures", "exposure")
_UNITS: Mapping[str, float] = {"hour": 3600.0, "km": 1000.0}
"""Seconds and metres of what rates are per; events count as they are."""
_MOST_BYTES = 20_000_000
Key = tuple[str, str]
"""What a hazard counts by, and what its failures leave; empty for the default."""


@dataclass(frozen=True)
class Row:
    """Failures seen in an exposure of hours, kilometres or events."""

    key: Key
    failures: float
    exposure: float
    digest: str


def read_counts(root: Path) -> tuple[list[Row], tuple[str, ...]]:
    """Read the counts of every `reliability.csv` below a folder; notices name copies, which count once.

    Raises InputError with every cell that is wrong.
    """
    rows: list[Row] = []
    problems: list[Problem] = []
    notices: list[str] = []
    texts: dict[str, Path] = {}
    repeated: Counter[str] = Counter()
    for path in sorted(root.rglob(FILE)):
        text = read_text(path, str(path), max_bytes=_MOST_BYTES).removeprefix("\ufeff")
        if text in texts:
            notices.append(f"{path.relative_to(root)} is a copy of {texts[text].relative_to(root)}, and is left out")
            continue
        texts[text] = path
        for row in _rows(text, str(path), problems):
            repeated[row.digest] += 1
            rows.append(Row(row.key, row.failures, row.exposure, digest_of([row.digest, repeated[row.digest]])))
    if problems:
        raise InputError(problems)
    return rows, tuple(notices)


def _rows(text: str, file: str, problems: list[Problem]) -> Iterator[Row]:
    reader = csv.DictReader(io.StringIO(text), skipinitialspace=True)
    missing = [name for name in COLUMNS if name not in (reader.fieldnames or ())]
    if missing:
        problems.append(Problem(f"lacks the column {missing[0]}; a log of failures has {', '.join(COLUMNS)}", file, 1))
        return
    for cells in reader:
        texts = {name: (cells.get(name) or "").strip() for name in (*COLUMNS, "leaves")}
        counts = {name: _count(texts[name]) for name in ("failures", "exposure")}
        wrong = list(_problems(texts, counts, file, reader.line_num))
        problems += wrong
        if not wrong and counts["exposure"] > 0.0:
            digest = digest_of(dict(cells))
            yield Row((texts["per"], texts["leaves"]), counts["failures"], counts["exposure"], digest)


def _problems(texts: Mapping[str, str], counts: Mapping[str, float], file: str, line: int) -> Iterator[Problem]:
    for name, choices in (("per", get_args(Per)), ("leaves", ("", *get_args(Leaves)))):
        if texts[name] not in choices:
            message = f"{name}: given {shown(texts[name])}, expected one of {', '.join(filter(None, choices))}"
            yield Problem(message, file, line, hint=did_you_mean(texts[name], choices))
    for name, count in counts.items():
        if not 0.0 <= count < math.inf:
            yield Problem(f"{name}: given {shown(texts[name])}, expected a number from 0", file, line)
    if counts["failures"] > 0.0 and counts["exposure"] == 0.0:
        yield Problem(f"{texts['failures']} failures in no exposure", file, line)


def _count(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def updated_rates(rows: Sequence[Row], mission: Mission | None) -> tuple[FailureRate, ...]:
    """Update each hazard that was counted: a gamma distribution of its rate, by failures and exposure.

    The prior is the mission's; a distribution of another form counts as the gamma of its mean and variance. Without
    one, or without uncertainty, it is Jeffreys' prior. Rows that the mission's hazard was learned from do not count.

    Raises InputError when a row could belong to two hazards of the mission.
    """
    hazards = mission.vehicle.reliability if mission is not None and mission.vehicle is not None else ()
    by_key: dict[Key, list[Hazard[Quantity]]] = {}
    for hazard in hazards:
        by_key.setdefault((hazard.per, hazard.leaves or ""), []).append(hazard)
    keys = dict.fromkeys(row.key for row in rows)
    if doubled := [key for key in keys if len(by_key.get(key, ())) > 1]:
        words = f"has two hazards per {doubled[0][0]} of which failures leave the same: counts cannot be parted"
        raise InputError([Problem(words, mission.file if mission else "", key="vehicle.reliability")])
    rates = []
    for key in keys:
        prior = next(iter(by_key.get(key, ())), None)
        hashes = set(prior.learned_from) if prior is not None else set()
        fresh = [row for row in rows if row.key == key and row.digest not in hashes]
        if fresh:
            rates.append(_updated(key, fresh, prior))
    return tuple(rates)


def _updated(key: Key, rows: Sequence[Row], hazard: "Hazard[Quantity] | None") -> FailureRate:
    """Add the counts of rows to what a hazard of the mission is worth."""
    failures, exposure = sum(row.failures for row in rows), sum(row.exposure for row in rows)
    before, law = _prior(hazard, _UNITS.get(key[0], 1.0))
    after = (before[0] + failures, before[1] + exposure)
    low, high = (float(rate_quantile(*after, share)) for share in (0.05, 0.95))
    return FailureRate(
        per=key[0],
        leaves=key[1],
        failures=failures,
        exposure=exposure,
        prior=law,
        prior_failures=before[0],
        prior_exposure=before[1],
        rate=(after[0] + 0.5) / after[1],
        low=low,
        high=high,
        surprise=chance_of_counts(failures, exposure, *before) if before[1] > 0.0 else 1.0,
        learned_from=(*(hazard.learned_from if hazard is not None else ()), *(row.digest for row in rows)),
    )


def _prior(hazard: "Hazard[Quantity] | None", unit: float) -> tuple[tuple[float, float], str]:
    """Failures and exposure that the mission's rate is worth, and in which form it holds it."""
    if hazard is None:
        return (0.0, 0.0), "none"
    if hazard.failures is not None and hazard.exposure is not None:
        return (hazard.failures, hazard.exposure), "counts"
    if hazard.rate is None:
        return (0.0, 0.0), "Weibull"
    mean, sd = mean_of(hazard.rate) * unit, sd_of(hazard.rate) * unit
    return (counts_of_rate(mean, sd), "distribution") if sd > 0.0 else ((0.0, 0.0), "fixed")


def rates_file(rates: Sequence[FailureRate], mission: Mission | None) -> str:
    """Write `reliability.yaml`: every hazard of the mission, updated where it was counted, to be named by a vehicle."""
    vehicle = mapping(mapping(mission.raw if mission else {}).get("vehicle"))
    hazards_written = mappings(vehicle.get("reliability"))
    written = [
        ((str(hazard.get("per", "")), str(hazard.get("leaves") or "")), dict(hazard)) for hazard in hazards_written
    ]
    counted = {(rate.per, rate.leaves): rate for rate in rates}
    sources = {key: str(hazard["source"]) for key, hazard in written if "source" in hazard}
    hazards = [hazard for key, hazard in written if key not in counted]
    for key, rate in counted.items():
        seen = f"{rate.failures:g} failure{'s' * (rate.failures != 1.0)} in {rate.exposure:g} {rate.unit} of the fleet"
        hazards.append(
            {
                "per": rate.per,
                "failures": rate.prior_failures + rate.failures,
                "exposure": rate.prior_exposure + rate.exposure,
                **({"leaves": rate.leaves} if rate.leaves else {}),
                "source": f"{sources[key]}; {seen}" if key in sources else seen,
                "learned_from": list(rate.learned_from),
            }
        )
    head = "# Failure rates, updated by `missionplan history`. In a vehicle file: `reliability: reliability.yaml`\n"
    return head + yaml.safe_dump(hazards, sort_keys=False, allow_unicode=True, width=120)
