"""The result of `tide`: constituents at each depth, a mean, what is left, and how well it forecast its own record."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

import pandas as pd
from typing_extensions import override

from missionplan.arrays import Array
from missionplan.results.base import Provenance, Result, to_csv, to_yaml
from missionplan.results.entries import Entry, Record


@dataclass(frozen=True)
class Constituent(Record):
    """A tidal ellipse; standard errors are nan where the constituent is inferred."""

    name: str
    """Such as ``M2``."""
    major: Annotated[float, Entry("major semi-axis", "m/s")]
    minor: Annotated[float, Entry("minor semi-axis; negative where the current turns clockwise", "m/s")]
    toward: Annotated[float, Entry("direction of the major axis, clockwise from north, below π", "rad")]
    phase: Annotated[float, Entry("lag behind the equilibrium tide at Greenwich", "rad")]
    major_error: Annotated[float, Entry("standard error of the major semi-axis", "m/s")] = math.nan
    minor_error: Annotated[float, Entry("standard error of the minor semi-axis", "m/s")] = math.nan
    toward_error: Annotated[float, Entry("standard error of the direction", "rad")] = math.nan
    phase_error: Annotated[float, Entry("standard error of the phase", "rad")] = math.nan
    inferred_from: str = ""
    """The constituent from which it is inferred; empty where it is fitted."""

    @property
    def fitted_constituent(self) -> Annotated[str | None, Entry(key="inferred_from")]:
        """The constituent from which it is inferred; None where it is fitted."""
        return self.inferred_from or None

    def in_degrees(self) -> dict[str, object]:
        """Return the row of the table, angles in degrees."""
        row = {**self.row(), "inferred_from": self.inferred_from}
        return {
            key.replace("_rad", "_deg"): math.degrees(value) if key.endswith("_rad") else value
            for key, value in row.items()
        }


@dataclass(frozen=True)
class HeldOut(Record):
    """How the tide of the first part of a record forecast the rest."""

    samples: Annotated[int, Entry("of one component in the rest")]
    coverage: Annotated[float, Entry("share of them within the stated 90 % interval", key="coverage_90")]
    error: Annotated[float, Entry("root mean square of one component", "m/s")]


@dataclass(frozen=True)
class DepthTide(Record):
    """The tide at one depth."""

    depth: Annotated[float, Entry("below the surface", "m")]
    samples: Annotated[int, Entry("moments at which the current was measured")]
    east: Annotated[float, Entry("mean current towards the east", "m/s")]
    north: Annotated[float, Entry("mean current towards the north", "m/s")]
    mean_error: Annotated[float, Entry("standard error of either component of the mean", "m/s")]
    constituents: tuple[Constituent, ...]
    """The largest first."""
    residual: Annotated[
        float,
        Entry(
            "standard deviation of one component about the tide and the mean, "
            "what the fit does not know of them included",
            "m/s",
        ),
    ]
    residual_time: Annotated[float, Entry("coherence time of what is left", "s")]
    tidal_share: Annotated[float, Entry("share of the current's variance that the tide explains")]
    held_out: Annotated[HeldOut | None, Entry("null where the record is too short to hold some of it out")]

    @property
    def by_name(self) -> Annotated[dict[str, Constituent], Entry(key="constituents")]:
        """Constituents by name, the largest first."""
        return {wave.name: wave for wave in self.constituents}


@dataclass(frozen=True)
class TideResult(Result):
    """The tide in a record of a current.

    Attributes
    ----------
    time, measured, fitted : array, shapes (k,), (2, k) and (2, k)
        At the depth of the picture: since 1970 [s], east and north; nan in gaps [m/s].
    """

    report: ClassVar[str] = "missionplan.studies.tide.page"

    provenance: Provenance
    depths: Annotated[tuple[DepthTide, ...], Entry("from the surface down")]
    latitude: Annotated[float, Entry("of the record", "rad")]
    begins: Annotated[float, Entry("begin of the record, since 1970", "s")]
    days: Annotated[float, Entry("length of the record [d]")]
    time: Array
    measured: Array
    fitted: Array
    shown_depth: float
    """Shown depth [m]."""
    unresolved: Annotated[tuple[str, ...], Entry("what the record is too short for, in words")]

    @property
    def forecast_error(self) -> str:
        """What the tide does not forecast, as ``site.current.error`` of a mission."""
        worst = max(self.depths, key=lambda tide: tide.residual)
        hours = max(worst.residual_time / 3600.0, 0.01)
        return f"{{sigma: {worst.residual:.4f} m/s, time: {hours:.2f} h}}"

    @property
    def shown(self) -> DepthTide:
        """The tide at the depth of the picture."""
        return next(each for each in self.depths if each.depth == self.shown_depth)

    @override
    def to_frame(self) -> pd.DataFrame:
        rows = [
            {"depth_m": each.depth, "constituent": wave.name, **wave.in_degrees()}
            for each in self.depths
            for wave in each.constituents
        ]
        return pd.DataFrame(rows)

    @override
    def files(self) -> dict[str, str | bytes]:
        return {"constituents.csv": to_csv(self.to_frame()), "tide.yaml": self.fragment()}

    def fragment(self) -> str:
        """Return `site.current.tide` of a mission, as the file that it may name."""
        head = (
            "# Phases are lags at Greenwich. In a mission:\n"
            f"# site: {{current: {{tide: tide.yaml, error: {self.forecast_error}}}}}\n"
        )
        return head + to_yaml({"depths": [_of_mission(each) for each in self.depths]})


def _of_mission(tide: DepthTide) -> Mapping[str, object]:
    return {
        "depth": f"{tide.depth:g} m",
        "east": f"{tide.east:.4f} m/s",
        "north": f"{tide.north:.4f} m/s",
        "constituents": [
            {
                "name": wave.name,
                "major": f"{wave.major:.4f} m/s",
                "minor": f"{wave.minor:.4f} m/s",
                "toward": f"{math.degrees(wave.toward):.2f} deg",
                "phase": f"{math.degrees(wave.phase):.2f} deg",
            }
            for wave in tide.constituents
        ],
    }
