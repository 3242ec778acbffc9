"""Result of `import`: a data set made of a vehicle's logs, and what was made of them."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Annotated, ClassVar, NamedTuple

import pandas as pd

from missionplan.arrays import Array
from missionplan.results import Provenance, Result, to_csv, to_json, to_yaml
from missionplan.results.entries import Entry, Record


@dataclass(frozen=True)
class SourceEntry(Record):
    """A file that was read."""

    name: Annotated[str, Entry("without its folder")]
    sha256: Annotated[str, Entry("of its contents")]


class Ability(NamedTuple):
    """What a diagnosis of the data can find, or not."""

    what: Annotated[str, Entry("that is to be found")]
    verdict: Annotated[str, Entry("whether it can be, and what is lacking if not")]


@dataclass(frozen=True)
class LogFigures(Record):
    """Numbers of a log; of one of dives, the depth alone. Not finite where the log does not say."""

    max_depth: Annotated[float, Entry("greatest depth", "m")]
    fixes: Annotated[int | None, Entry("that count", optional=True)] = None
    velocity_error_sigma: Annotated[
        float | None, Entry("root mean square about the mean, each axis", "m/s", optional=True)
    ] = None
    velocity_error_mean_east: Annotated[float | None, Entry("of the legs", "m/s", optional=True)] = None
    velocity_error_mean_north: Annotated[float | None, Entry("of the legs", "m/s", optional=True)] = None
    leg_length: Annotated[float | None, Entry("median", "m", optional=True)] = None
    leg_duration: Annotated[float | None, Entry("median", "s", optional=True)] = None
    speed: Annotated[float | None, Entry("median of the legs", "m/s", optional=True)] = None
    surfacing_time: Annotated[
        float | None, Entry("median, from surfacing to the next leg's start", "s", optional=True)
    ] = None
    fix_sd: Annotated[float | None, Entry("median of a fix, each axis", "m", optional=True)] = None
    record: Annotated[float | None, Entry("time from the first fix to the last", "s", optional=True)] = None
    made_reckoning_sd: Annotated[
        float | None, Entry("median of a leg's reckoning that was made of other readings", "m", optional=True)
    ] = None
    current_in_reckoning: Annotated[
        float | None, Entry("share of the vehicle's own estimate of the current in its reckoning", optional=True)
    ] = None


@dataclass(frozen=True)
class TrackLines:
    """What the report draws, east and north of the data set's origin [m]."""

    fixes: Array
    rejected: Array
    """Fixes that count, and those that do not, shape (2, n)."""
    reckoned: tuple[Array, ...]
    """Dead-reckoned way of each dive; empty where there is none; shape (2, k)."""
    leg_starts: Array
    """Fix before each dive, shape (2, dives)."""
    leg_ends: Array
    """Dead-reckoned end of each dive, then the fix after it; nan where there is none; shape (2, 2, dives)."""
    depth_t: Array
    depth: Array
    """Depth record, thinned, shape (m,) [s, m]."""


@dataclass(frozen=True)
class Basis(Record):
    """What all legs rest on; depths are below what the gauge reads at the surface."""

    dive_depth: Annotated[float, Entry("depth that a dive reaches", "m")]
    surface_depth: Annotated[float, Entry("depth above which the vehicle is at the surface", "m")]
    gauge_zero: Annotated[float, Entry("what the gauge reads at the surface", "m")]
    gauge_zero_by: Annotated[str, Entry("what shows that: `state` of the vehicle, `fixes`, or `assumed`")]
    heading: Annotated[str, Entry("north that headings are from")]
    speed: Annotated[str, Entry("where speeds come from")]
    shortest: Annotated[float, Entry("time from fix to fix that a leg lasts at least", "s")]
    longest_gap: Annotated[float, Entry("time without a reading under water that a leg has at most", "s")]


@dataclass(frozen=True)
class LegPicture:
    """What was logged about one leg, drawn on request; places east and north of the fix before it [m]."""

    row: int
    """Of the dives."""
    fix_t: Array
    fixes: Array
    """Fixes that count, from a while before the leg to a while after it: times since its start [s], and places, shape
    (n,), (2, n)."""
    rejected_t: Array
    rejected: Array
    """Those that do not, shape (k,), (2, k)."""
    reasons: tuple[str, ...]
    """Why not."""
    reckoned_t: Array
    reckoned: Array
    """Dead-reckoned positions, shape (m,), (2, m)."""
    depth_t: Array
    depth: Array
    """Readings of depth, shape (d,) [s, m]."""


@dataclass(frozen=True)
class ImportedData(Result):
    """Result of `import`."""

    report: ClassVar[str] = "missionplan.report.imported"
    provenance: Provenance
    kind: Annotated[str, Entry("of the data set")]
    name: Annotated[str, Entry("of the data set", key="dataset")]
    format: Annotated[str, Entry("of the logs")]
    dataset: Mapping[str, object]
    """Contents of ``dataset.yaml``."""
    table: pd.DataFrame = field(repr=False)
    """The data set's CSV."""
    dives: pd.DataFrame = field(repr=False)
    """Every dive that was found, with `ok` and `reason`."""
    sources: Annotated[tuple[SourceEntry, ...], Entry("files that were read")]
    passed_over: Annotated[tuple[str, ...], Entry("files that were not read, with the reason")]
    reckoning: Annotated[str, Entry("where dead-reckoned positions come from, in words")]
    rejected_fixes: pd.DataFrame = field(repr=False)
    """Fixes that do not count, with the reason."""
    mission_text: str
    """The starter mission, as written."""
    can_show: Annotated[
        tuple[Ability, ...], Entry("what a diagnosis of this data can find, and what it lacks for the rest")
    ]
    next_commands: Annotated[tuple[str, ...], Entry("commands that may follow", key="next")]
    figures: Annotated[LogFigures, Entry(inline=True)]
    """Fixes, lengths, speeds, errors."""
    lines: TrackLines = field(repr=False)
    extra_files: Mapping[str, str] = field(default_factory=dict, repr=False)
    """Further files, by name: the starter's vehicle."""
    basis: Annotated[Basis | None, Entry("what the legs rest on", key="legs_rest_on", optional=True)] = None
    """What legs rest on; what each does is in `dives`. None for dives of a depth record."""
    pictures: tuple[LegPicture, ...] = ()
    """Of the legs that were to be explained."""

    @property
    def counted(self) -> Annotated[int, Entry()]:
        """Number of dives that count."""
        return int(self.dives["ok"].sum())

    @property
    def durations(self) -> Array:
        """Time of each dive, from fix to fix where it is a leg [s]."""
        return (self.dives["t_end_s"] - self.dives["t_start_s"]).to_numpy()

    @property
    def rejected_reasons(self) -> Annotated[dict[str, int], Entry(key="rejected_fixes")]:
        """Why fixes do not count, with how many."""
        return _counts(self.rejected_fixes["reason"])

    @property
    def reasons(self) -> Annotated[dict[str, int], Entry(key="left_out")]:
        """Why dives do not count, with how many."""
        return _counts(self.dives.loc[self.dives["ok"] == 0, "reason"])

    @property
    def number_of_dives(self) -> Annotated[int, Entry(key="dives")]:
        """Number of dives that were found."""
        return len(self.dives)

    @property
    def is_of_legs(self) -> bool:
        """Whether its groups are legs."""
        return self.kind == "transit"

    @property
    def groups(
        self,
    ) -> Annotated[
        int,
        Entry(key="legs", when=attrgetter("is_of_legs")),
        Entry(key="runs", when=lambda data: not data.is_of_legs),
    ]:
        """Number of legs or runs in the table."""
        return len(self.table.groupby(self.table.columns[0]))

    def to_frame(self) -> pd.DataFrame:
        """The data set's table."""
        return self.table

    def files(self) -> dict[str, str | bytes]:
        """Return the data set, the table of all dives, and the starter mission with its comments."""
        return {
            "dataset.yaml": to_yaml(self.dataset),
            str(self.dataset["file"]): to_csv(self.table),
            "all-dives.csv": to_csv(self.dives),
            "rejected-fixes.csv": to_csv(self.rejected_fixes),
            "import.json": to_json(self.summary()),
            "mission.yaml": self.mission_text,
            **self.extra_files,
        }


def _counts(reasons: Sequence[str] | pd.Series) -> dict[str, int]:
    """Count reasons, without the numbers that stand in brackets; the most frequent first."""
    counts = Counter(re.sub(r" \([^)]*\)", "", one) for reason in reasons for one in str(reason).split("; "))
    return dict(counts.most_common())
