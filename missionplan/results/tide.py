"""The result of `tide`: constituents at each depth, a mean, what is left, and how well it forecast its own record."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import pandas as pd
from typing_extensions import override

from missionplan.arrays import Array
from missionplan.results.base import Provenance, Result, to_csv, to_yaml


@dataclass(frozen=True)
class Constituent:
    """A tidal ellipse.

    Attributes
    ----------
    name : str
        Such as ``M2``.
    major, minor : float
        Semi-axes; a negative minor axis turns clockwise [m/s].
    toward : float
        Of the major axis, clockwise from north, below π [rad].
    phase : float
        Lag behind the equilibrium tide at Greenwich [rad].
    major_error, minor_error, toward_error, phase_error : float
        Standard errors [m/s, m/s, rad, rad]; nan where the constituent is inferred.
    inferred_from : str
        The constituent from which it is inferred; empty where it is fitted.
    """

    name: str
    major: float
    minor: float
    toward: float
    phase: float
    major_error: float = math.nan
    minor_error: float = math.nan
    toward_error: float = math.nan
    phase_error: float = math.nan
    inferred_from: str = ""


@dataclass(frozen=True)
class HeldOut:
    """How the tide of the first part of a record forecast the rest.

    Attributes
    ----------
    samples : int
        Of one component in the rest.
    coverage : float
        Share of them within the stated 90 % interval.
    error : float
        Root mean square of one component [m/s].
    """

    samples: int
    coverage: float
    error: float


@dataclass(frozen=True)
class DepthTide:
    """The tide at one depth.

    Attributes
    ----------
    depth : float
        [m]
    samples : int
        Moments at which the current was measured.
    east, north, mean_error : float
        Mean current, and the standard error of either component [m/s].
    constituents : tuple of Constituent
        The largest first.
    residual : float
        Standard deviation of one component about the tide and the mean, what the fit does not know of them included
        [m/s].
    residual_time : float
        Coherence time of what is left [s].
    tidal_share : float
        Share of the current's variance that the tide explains.
    held_out : HeldOut or None
        None where the record is too short to hold some of it out.
    """

    depth: float
    samples: int
    east: float
    north: float
    mean_error: float
    constituents: tuple[Constituent, ...]
    residual: float
    residual_time: float
    tidal_share: float
    held_out: HeldOut | None


@dataclass(frozen=True)
class TideResult(Result):
    """The tide in a record of a current.

    Attributes
    ----------
    depths : tuple of DepthTide
        From the surface down.
    latitude : float
        [rad]
    begins, days : float
        Of the record: since 1970 [s], and its length [d].
    time, measured, fitted : array, shapes (k,), (2, k) and (2, k)
        At the depth of the picture: since 1970 [s], east and north; nan in gaps [m/s].
    shown_depth : float
        [m]
    unresolved : tuple of str
        What the record is too short for, in words.
    """

    report: ClassVar[str] = "missionplan.report.tide"

    provenance: Provenance
    depths: tuple[DepthTide, ...]
    latitude: float
    begins: float
    days: float
    time: Array
    measured: Array
    fitted: Array
    shown_depth: float
    unresolved: tuple[str, ...]

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
    def summary(self) -> dict[str, object]:
        return {
            **self.provenance.summary(),
            "latitude_rad": self.latitude,
            "begins_s": self.begins,
            "days": self.days,
            "unresolved": list(self.unresolved),
            "depths": [_summary(each) for each in self.depths],
        }

    @override
    def to_frame(self) -> pd.DataFrame:
        return pd.DataFrame(
            [
                {
                    "depth_m": each.depth,
                    "constituent": wave.name,
                    "major_m_s": wave.major,
                    "minor_m_s": wave.minor,
                    "toward_deg": math.degrees(wave.toward),
                    "phase_deg": math.degrees(wave.phase),
                    "major_error_m_s": wave.major_error,
                    "minor_error_m_s": wave.minor_error,
                    "toward_error_deg": math.degrees(wave.toward_error),
                    "phase_error_deg": math.degrees(wave.phase_error),
                    "inferred_from": wave.inferred_from,
                }
                for each in self.depths
                for wave in each.constituents
            ]
        )

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


def _summary(tide: DepthTide) -> dict[str, object]:
    held = tide.held_out
    return {
        "depth_m": tide.depth,
        "samples": tide.samples,
        "east_m_s": tide.east,
        "north_m_s": tide.north,
        "mean_error_m_s": tide.mean_error,
        "residual_m_s": tide.residual,
        "residual_time_s": tide.residual_time,
        "tidal_share": tide.tidal_share,
        "held_out": {"samples": held.samples, "coverage_90": held.coverage, "error_m_s": held.error} if held else None,
        "constituents": {
            wave.name: {
                "major_m_s": wave.major,
                "minor_m_s": wave.minor,
                "toward_rad": wave.toward,
                "phase_rad": wave.phase,
                "major_error_m_s": wave.major_error,
                "minor_error_m_s": wave.minor_error,
                "toward_error_rad": wave.toward_error,
                "phase_error_rad": wave.phase_error,
                "inferred_from": wave.inferred_from or None,
            }
            for wave in tide.constituents
        },
    }


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
