"""`sweep-transition`: depth, pitch and energy of slowing down, over the grid of Palmer et al., Table 2."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
import pandas as pd
from scipy.optimize import brentq

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.mission import MissionOrPath
from missionplan.mission.schema.manoeuvring import TransitionGrid
from missionplan.mission.views import TransitionMission
from missionplan.montecarlo.blocks import Progress
from missionplan.phases.transition_plan import Manoeuvre, TransitionRecord, TransitionVehicle, energy_until
from missionplan.phases.transition_simulation import simulate_transition
from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.physics.tunnel_thruster import hover_power, revolutions_for
from missionplan.physics.vehicle_dynamics import level_trim
from missionplan.results import Provenance, Result, to_csv, to_grid
from missionplan.results.entries import Entry
from missionplan.scenario.phases import manoeuvre, transition_vehicle
from missionplan.scenario.scenario import Scenario
from missionplan.studies.run import Run

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
    """Result of `sweep-transition`."""

    report: ClassVar[str] = "missionplan.studies.transition_page"
    provenance: Provenance
    cells: pd.DataFrame
    """One run per row: `variant`, `deceleration_m_s2`, `steepness_m_s`, `mid_speed_m_s`, `depth_excursion_m`,
    `pitch_excursion_rad`, `hover_time_s`, `hover_pitch_rad`, `energy_common_wh` (option (a): until the slowest run of
    the set hovers), `energy_to_hover_wh` (option (b)), `energy_out_of_range` (share)."""
    shown_deceleration: float
    unassisted: TimeHistory
    """Without thrusters (Fig. 3)."""
    saturation_speed: Annotated[
        float,
        Entry("at which the sternplanes reach their limit in level flight, point A; null if they never do", "m/s"),
    ]
    by_mid_speed: tuple[TimeHistory, ...]
    by_steepness: tuple[TimeHistory, ...]
    """One thruster, force alone, at the shown deceleration (Figs. 6 to 9)."""
    by_variant: tuple[TimeHistory, ...]
    """The variants at the shown deceleration, steepness and mid-transition speed (Fig. 14)."""
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
        least = int(cells["energy_common_wh"].fillna(np.inf).to_numpy(dtype=float).argmin())
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


SAMPLE = 1.0
"""Interval of the histories [s]."""


class GridRuns:
    """Every combination of a grid, run side by side.

    `manoeuvre`: its deceleration, steepness and mid-transition speed are replaced by the grid's. `time_step`: [s].
    """

    def __init__(
        self, grid: TransitionGrid, vehicle: TransitionVehicle, manoeuvre: Manoeuvre, time_step: float
    ) -> None:
        axes = (grid.deceleration, grid.steepness, grid.mid_speed)
        self._shape = tuple(len(axis) for axis in axes)
        self._points: Array = np.array([grid_axis.ravel() for grid_axis in np.meshgrid(*axes, indexing="ij")])
        deceleration, steepness, mid_speed = self._points
        varied = replace(manoeuvre, deceleration=deceleration, steepness=steepness, mid_speed=mid_speed)
        self._record = simulate_transition(vehicle, varied, time_step=time_step, sample=SAMPLE)

    def table(self, variant: str) -> pd.DataFrame:
        """One run a row."""
        record = self._record
        # option (a): until the slowest of each set of mid-transition speeds hovers; nan where one of them never does
        latest = record.hover_time.reshape(self._shape).max(axis=2, keepdims=True)
        until = np.broadcast_to(latest, self._shape).ravel()
        common = np.where(np.isnan(until), np.nan, energy_until(record.history, np.nan_to_num(until)))
        return pd.DataFrame(
            {
                "variant": variant,
                "deceleration_m_s2": self._points[0],
                "steepness_m_s": self._points[1],
                "mid_speed_m_s": self._points[2],
                "depth_excursion_m": record.depth_excursion,
                "pitch_excursion_rad": record.pitch_excursion,
                "hover_time_s": record.hover_time,
                "hover_pitch_rad": record.hover_pitch,
                "energy_common_wh": common / JOULES_PER_WATT_HOUR,
                "energy_to_hover_wh": record.energy_to_hover / JOULES_PER_WATT_HOUR,
                "energy_out_of_range": record.out_of_range,
            }
        )

    def history(self, point: tuple[float, float, float], label: str) -> TimeHistory:
        """Time history of one combination: deceleration, steepness and mid-transition speed."""
        index = int(np.flatnonzero(np.all(self._points == np.array(point)[:, None], axis=0))[0])
        return time_history(self._record, index, label)


def time_history(record: TransitionRecord, index: int, label: str) -> TimeHistory:
    """Time history of one trial of a record."""
    history = record.history
    columns = (history.speed, history.pitch, history.depth, history.sternplane)
    speed, pitch, depth, sternplane = (column[:, index] for column in columns)
    return TimeHistory(label, history.time, speed, pitch, depth, sternplane)


LOWEST_SPEED = 0.3
"""Speed down to which point A is sought [m/s]."""


def sweep_transition(
    mission: MissionOrPath, *, phase: str | None = None, time_step: float = 0.5, progress: Progress | None = None
) -> TransitionSweep:
    """Run the grid of a mission's transition phase, at the means of everything uncertain.

    Parameters
    ----------
    mission : Mission, str or Path
        With a transition phase and a vehicle with `manoeuvring` and at least one tunnel thruster.
    phase : str, optional
        The transition's name; default the first.
    time_step : float
        Of the runs and their controllers [s].
    progress : callable, optional
        Called with the variants of the vehicle done and their total.

    Raises
    ------
    InputError
        When the mission lacks what a transition needs.
    """
    run = Run.begun("sweep-transition", mission, progress=progress)
    mission = run.mission
    scenario = Scenario.at_means(mission)
    transition = TransitionMission.of(scenario.drawn).transition(phase)
    vehicle = replace(transition_vehicle(scenario, transition), suction_moment=False)
    if not vehicle.thrusters:
        raise InputError([Problem("missing; the sweep needs a tunnel thruster", mission.file, key="vehicle.thrusters")])
    grid, planned = transition.sweep, manoeuvre(transition)
    variants = _variants(vehicle, grid.pair_spacing)

    at_shown = grid.model_copy(update={"deceleration": (grid.shown_deceleration,)})

    def run_variant(name: str) -> GridRuns:
        return GridRuns(grid if name == FORCE else at_shown, variants[name], planned, time_step)

    runs = dict(zip(variants, run.workers.run(run_variant, list(variants)), strict=True))
    record = simulate_transition(
        replace(vehicle, thrusters=()),
        replace(planned, deceleration=grid.shown_deceleration, after=20.0),
        time_step=time_step,
        sample=SAMPLE,
    )
    unassisted = time_history(record, 0, "no thrusters")
    options = {"phase": transition.name, "time_step": time_step}
    provenance = run.provenance(options, mission.notices(), trials=0)
    deceleration, steepness, mid_speed = shown = (grid.shown_deceleration, grid.shown_steepness, grid.shown_mid_speed)
    thruster, force = vehicle.thrusters[0], float(vehicle.body.excess_buoyancy)
    density = vehicle.body.density
    return TransitionSweep(
        provenance=provenance,
        cells=pd.concat([run.table(name) for name, run in runs.items()], ignore_index=True),
        shown_deceleration=deceleration,
        unassisted=unassisted,
        saturation_speed=saturation_speed(vehicle, planned.start_speed),
        by_mid_speed=tuple(runs[FORCE].history((deceleration, steepness, u), f"{u:g}") for u in grid.mid_speed),
        by_steepness=tuple(runs[FORCE].history((deceleration, s, mid_speed), f"{s:g}") for s in grid.steepness),
        by_variant=tuple(run.history(shown, name) for name, run in runs.items()),
        hover={
            "thrust_n": force,
            "revolutions_per_s": float(revolutions_for(thruster.thrust_constant, force)),
            "power_w": hover_power(force, thruster.area, density),
            "pair_power_w": hover_power(force, thruster.area, density, thrusters=2),
        },
    )


def _variants(vehicle: TransitionVehicle, spacing: float | None) -> dict[str, TransitionVehicle]:
    """The paper's three: force alone at the centre, with the jet's suction, and a pair of the same thruster."""
    one = replace(vehicle.thrusters[0], position=0.0)
    half = (vehicle.body.length / 2.0 if spacing is None else spacing) / 2.0
    pair = (replace(one, position=half), replace(one, position=-half))
    return {
        FORCE: replace(vehicle, thrusters=(one,)),
        SUCTION: replace(vehicle, thrusters=(one,), suction_moment=True),
        PAIR: replace(vehicle, thrusters=pair, suction_moment=True),
    }


def saturation_speed(vehicle: TransitionVehicle, start_speed: float) -> float:
    """Speed at which level flight needs the sternplanes' limit, point A of Fig. 3 [m/s]; nan if it never does.

    Bracketed from the survey speed down, then found by Brent's method (Brent 1973, ch. 4).
    """

    def beyond(speed: float) -> float:
        return float(level_trim(vehicle.body, speed).sternplane) - vehicle.sternplanes.limit

    speeds = np.arange(start_speed, LOWEST_SPEED, -0.02)
    for slower, faster in zip(speeds[1:], speeds[:-1], strict=True):
        if beyond(slower) >= 0.0:
            return float(brentq(beyond, slower, faster))
    return float("nan")
