"""Result of `sweep-transition`: depth, pitch and energy of slowing down, over the grid of Palmer et al., Table 2."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

import pandas as pd

from missionplan.arrays import Array
from missionplan.results.base import Provenance, Result, to_csv, to_grid
from missionplan.results.entries import Entry

if TYPE_CHECKING:
    import xarray

FORCE, SUCTION, PAIR = "one thruster, force alone", "one thruster with suction", "thruster pair"
"""Variants, in the order of the paper: sections 6, 7.1 and 7.2."""


@dataclass(frozen=True)
class TimeHistory:
    """Time history of one run, from the start of the deceleration; depth is below the target.

    Arrays of shape (samples,): `time` [s], `speed` [m/s], `pitch` and `sternplane` [rad], `depth` [m].
    """

    label: str
    time: Array
    speed: Array
    pitch: Array
    depth: Array
    sternplane: Array


@dataclass(frozen=True)
class TransitionSweep(Result):
    """Result of `sweep-transition`.

    Attributes
    ----------
    cells : DataFrame
        One run per row: `variant`, `deceleration_m_s2`, `steepness_m_s`, `mid_speed_m_s`, `depth_excursion_m`,
        `pitch_excursion_rad`, `hover_time_s`, `hover_pitch_rad`, `energy_common_wh` (option (a): until the slowest
        run of the set hovers), `energy_to_hover_wh` (option (b)), `energy_out_of_range` (share).
    unassisted : TimeHistory
        Without thrusters (Fig. 3).
    by_mid_speed, by_steepness : tuple of TimeHistory
        One thruster, force alone, at the shown deceleration (Figs. 6 to 9).
    by_variant : tuple of TimeHistory
        The variants at the shown deceleration, steepness and mid-transition speed (Fig. 14).
    """

    report: ClassVar[str] = "missionplan.studies.transition.page"
    provenance: Provenance
    cells: pd.DataFrame
    shown_deceleration: float
    unassisted: TimeHistory
    saturation_speed: Annotated[
        float,
        Entry("at which the sternplanes reach their limit in level flight, point A; null if they never do", "m/s"),
    ]
    by_mid_speed: tuple[TimeHistory, ...]
    by_steepness: tuple[TimeHistory, ...]
    by_variant: tuple[TimeHistory, ...]
    hover: Annotated[
        Mapping[str, float],
        Entry("`thrust_n`, `revolutions_per_s`, `power_w` of one thruster and `pair_power_w` at hover"),
    ]

    def shown(self, variant: str) -> pd.DataFrame:
        """Cells of a variant at the shown deceleration."""
        chosen = (self.cells["variant"] == variant) & (self.cells["deceleration_m_s2"] == self.shown_deceleration)
        return self.cells[chosen]

    def energy(self, variant: str, option: str) -> pd.DataFrame:
        """Energy at the shown deceleration [Wh]: mid-transition speeds down, steepnesses across; option "a" or "b"."""
        column = "energy_common_wh" if option == "a" else "energy_to_hover_wh"
        return self.shown(variant).pivot(index="mid_speed_m_s", columns="steepness_m_s", values=column)

    @property
    def best(self) -> Annotated[dict[str, float], Entry(key="least_energy")]:
        """Cell of least energy by option (a), one thruster, force alone, at the shown deceleration."""
        cells = self.shown(FORCE).drop(columns="variant")
        least = int(cells["energy_common_wh"].to_numpy(dtype=float).argmin())
        return {str(name): float(value) for name, value in cells.iloc[least].items()}

    @property
    def runs(self) -> Annotated[int, Entry()]:
        """Number of runs."""
        return len(self.cells)

    @property
    def rows(self) -> Annotated[list[dict[str, object]], Entry(key="cells")]:
        """The runs, as rows of the table."""
        return [{str(name): value for name, value in row.items()} for row in self.cells.to_dict(orient="records")]

    def to_frame(self) -> pd.DataFrame:
        """One run per row."""
        return self.cells.copy()

    def to_xarray(self) -> "xarray.Dataset":
        """Return the runs as arrays over variant, deceleration, steepness and speed; needs the extra ``netcdf``."""
        unit = {
            "deceleration_m_s2": "m/s^2",
            "steepness_m_s": "m/s",
            "mid_speed_m_s": "m/s",
            "depth_excursion_m": "m",
            "pitch_excursion_rad": "rad",
            "energy_common_wh": "W h",
            "energy_to_hover_wh": "W h",
        }
        return to_grid(self.cells, ("variant", "deceleration_m_s2", "steepness_m_s", "mid_speed_m_s"), unit)

    def files(self) -> dict[str, str | bytes]:
        """Return the table of all runs."""
        return {"transition.csv": to_csv(self.cells)}
