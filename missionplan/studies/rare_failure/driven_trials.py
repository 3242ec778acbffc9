"""Trials as functions of standard normals, which a search drives towards failure by the margins of the ways to fail."""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.errors import InputError, Problem, RunError
from missionplan.mission import Mission
from missionplan.mission.changes import unit_of
from missionplan.mission.checks.sections import quantity_unit
from missionplan.mission.quantity_paths import resolved_path
from missionplan.mission.schema.phases import MoorPhase, Phase, TransitPhase
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.montecarlo.distributions import Choices, WhichHolds
from missionplan.montecarlo.rare_events import Key
from missionplan.montecarlo.rare_events.strata import DiscreteValue, StrataView, TrialMargins
from missionplan.phases.ensemble import Ensemble
from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.results.failures import MET, Counted, CountedKind, Failure
from missionplan.scenario.phases import line_strength
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import MEMBER
from missionplan.studies.simulation.block_statistics import SCALES, failures_by_step, requirement_key
from missionplan.studies.simulation.phase_trials import SIDES, UNITS_OF_LEGS, Flags, PhaseTrials
from missionplan.studies.simulation.trial_block import MissionTrials, run_trials

_NOT_ARRIVED, _OUTSIDE, _STRUCK = Failure.NOT_ARRIVED, Failure.OUTSIDE, Failure.STRUCK
_DRAGGED, _GROUNDED = Failure.DRAGGED, Failure.GROUNDED
_WORLD = (*MET.values(), Failure.EQUIPMENT)
_REASONS = {
    "arrived": (_NOT_ARRIVED, Failure.OUT_OF_ENERGY, *_WORLD),
    "within_radius": (_OUTSIDE, Failure.TOO_SHALLOW, Failure.TOO_LIGHT, Failure.LINE_PARTED, *_WORLD),
    "struck_seafloor": (_STRUCK,),
    "anchor_holds": (_DRAGGED, Failure.TOO_SHALLOW, Failure.TOO_LIGHT, Failure.LINE_PARTED, *_WORLD),
    "grounded": (_GROUNDED,),
    "line_parts": (Failure.LINE_PARTED,),
    "hovering": (Failure.OUT_OF_ENERGY, Failure.EQUIPMENT),
}
"""Ways in which a phase's event fails, by the event."""
FAILS = "not total.success"
"""The default event."""
_FAILURES = ("struck_seafloor", "grounded", "line_parts")
"""Events that are failures themselves; of the others the failure is that they do not happen."""
_FORM = re.compile(r"(?P<negated>not\s+)?(?P<quantity>[^<>=]+?)\s*(?:(?P<sign>[<>])=?\s*(?P<limit>[^<>=]+))?")
_HINT = "such as 'not total.success', moor.struck_seafloor, 'not ingress.arrived' or 'moor.offset > 30 m'"


@dataclass(frozen=True)
class RareEvent:
    """A failure."""

    text: str
    """With what stands for the phase in key paths, and blanks about the sign."""
    key: str
    """Column of the table of trials: ``total.success``, ``moor.offset_m``."""
    sign: int = 0
    """1 where the failure is a value above the limit, -1 where it is one below, 0 for an event."""
    limit: float = 0.0
    """In the unit of the column."""
    negated: bool = False
    """Whether the failure is that an event does not happen."""

    @classmethod
    def parse(cls, text: str, mission: Mission) -> "RareEvent":
        """Read ``not PHASE.EVENT``, ``PHASE.EVENT`` (one that is a failure), or ``PHASE.QUANTITY > LIMIT``.

        Raises InputError when the mission has no such quantity, the limit cannot be read, or the event is no failure.
        """
        text = " ".join(text.split())
        match = _FORM.fullmatch(text)
        if match is None:
            raise _wrong(text, "expected an event or a quantity with its limit")
        sign, limit, negated = match["sign"], match["limit"], match["negated"] is not None
        quantity = resolved_path(match["quantity"], [phase.label for phase in mission.phases], with_sections=False)
        text = f"{quantity} {sign} {limit}" if sign else f"{'not ' * negated}{quantity}"
        try:
            unit = quantity_unit(quantity, mission.phases)
            if unit is None:
                name = quantity.rpartition(".")[2]
                if limit is not None:
                    raise _wrong(text, f"{name} is an event: it has no limit")
                if negated == (name in _FAILURES):
                    expected = quantity if negated else f"not {quantity}"
                    raise _wrong(text, f"{text} is no failure, expected {expected}")
                return cls(text, quantity, negated=negated)
            if negated or limit is None:
                raise _wrong(text, f"{quantity} is a quantity: give the limit beyond which it is a failure")
            size = parse_number_with_unit(float(limit) if unit == "" else limit, unit) * SCALES.get(unit, 1.0)
        except (QuantityError, ValueError) as error:
            raise _wrong(text, str(error)) from None
        return cls(text, requirement_key(mission, quantity)[0], 1 if sign == ">" else -1, size)

    @property
    def phase(self) -> str:
        """Phase of the event, or ``total``."""
        return self.key.rpartition(".")[0]

    @property
    def name(self) -> str:
        """Event or quantity of that phase."""
        return self.key.rpartition(".")[2]

    @property
    def is_quantity(self) -> bool:
        """Whether the failure is a value beyond a limit."""
        return self.sign != 0

    def happens(self, columns: Mapping[str, Array | Flags]) -> Flags:
        """In which trials the failure happens; a value that was never reached lies beyond no limit."""
        values = columns[self.key]
        if self.is_quantity:
            return np.asarray(self.sign * (values - self.limit) > 0.0)
        flags = np.asarray(values, dtype=bool)
        return ~flags if self.negated else flags


def _wrong(text: str, message: str) -> InputError:
    return InputError([Problem(f"given {text!r}: {message}", key="rare", hint=_HINT)])


def margins(event: RareEvent, trials: MissionTrials, scenario: Scenario) -> dict[str, Array]:
    """Return the margins that matter for an event, by the way to fail; nan where a trial never came so far."""
    if event.is_quantity:
        values = np.asarray(trials.columns()[event.key], dtype=float)
        return {event.text: event.sign * (event.limit - values)}
    by_way: dict[str, Array] = {}
    spent: Scalars = 0.0
    for phase, done in zip(scenario.drawn.phases, trials.phases, strict=True):
        spent = spent + done.quantities["energy_wh"] if "energy_wh" in done.quantities else spent
        by_reason = dict(_of_phase(phase, done, scenario, spent))
        ends_here = phase.name == event.phase
        chosen = _REASONS.get(event.name, ()) if ends_here else tuple(by_reason) if event.negated else ()
        by_way |= {
            str(Counted(CountedKind.FAILURE, phase.name, reason)): by_reason[reason]
            for reason in chosen
            if reason in by_reason
        }
        if ends_here:
            break
    return by_way


def _of_phase(
    phase: "Phase[Scalars]", done: PhaseTrials, scenario: Scenario, spent: Scalars
) -> Iterator[tuple[str, Array]]:
    """Margins of one phase; `spent` until its end [W h]."""
    for reason, values in done.margins.items():
        yield reason, _each(values, done)
    if isinstance(phase, TransitPhase):
        # legs left on arrival, less the share of the arrival radius used up: a trial just inside nearly needed another
        used = done.quantities["surfacings"] + np.minimum(done.quantities["arrival_error_m"] / done.radius, 1.0)
        yield _NOT_ARRIVED, scenario.navigation.max_legs + 1.0 - used
    elif isinstance(phase, MoorPhase):
        quantities = done.quantities
        yield Failure.TOO_LIGHT, quantities["terminal_velocity_m_s"]
        yield _OUTSIDE, done.radius - quantities["offset_m"]
        yield _STRUCK, quantities["lowest_altitude_m"]
        yield _DRAGGED, quantities["holding_margin"]
        yield _GROUNDED, quantities["nose_altitude_m"]
        strength = line_strength(phase)
        if strength is not None:
            tension = np.fmax(
                quantities["line_tension_n"], quantities.get("snatch_tension_n", quantities["line_tension_n"])
            )
            yield Failure.LINE_PARTED, strength - tension
    left = scenario.capacity / JOULES_PER_WATT_HOUR - spent
    if np.all(np.isfinite(scenario.capacity)):
        yield Failure.OUT_OF_ENERGY, _each(left, done)


def _each(values: Scalars, done: PhaseTrials) -> Array:
    """One value a trial that reached the phase; nan for the others."""
    return np.where(np.isnan(done.start), np.nan, values)


@dataclass(frozen=True)
class _OfLegs:
    population: StrataView
    quantity: str

    def leg(self, number: int) -> Array:
        return self.population.cell(self.quantity, number, 2)


@dataclass(frozen=True)
class PopulationSource:
    """The normals of a population, as the phases of a mission draw them."""

    population: StrataView

    def once(self, quantity: str) -> Array:
        """Normals of a quantity that is drawn once a trial, shape (n,)."""
        return np.asarray(self.population.cell(quantity)[0])

    def legs(self, quantity: str) -> _OfLegs:
        """Normals of a quantity that is drawn anew for each leg."""
        return _OfLegs(self.population, _by_leg(quantity))


def _by_leg(quantity: str) -> str:
    return f"{quantity} by leg"


@dataclass(frozen=True)
class FailingTrials:
    """Trials that fail."""

    weights: Array
    """Shape (n,)."""
    columns: Mapping[str, NDArray[np.generic]]
    """What was drawn, and what came of it, shape (n,)."""
    inputs: tuple[str, ...]
    """Names of the columns that were drawn."""
    steps: NDArray[np.str_]
    """Shape (n,). Where each fails first, ``moor: anchor outside the radius``; empty where the mission succeeds all the
    same."""


@dataclass(frozen=True, eq=False)  # hashed by identity, as a block's task is
class DrivenMission:
    """A mission to be run from given normals, with the event that is asked about."""

    means: Scenario
    event: RareEvent
    ways: tuple[str, ...] = field(default=())
    """Ways to fail, in the order of their margins; those of the mission's, which each trial has."""

    def run(self, population: StrataView, *, inputs: bool = False) -> tuple[Scenario, MissionTrials]:
        """Run one trial for each of a population; raises RunError when the model fails numerically."""
        source = PopulationSource(population)
        scenario = self.means.sampled_from(source, population.trials)
        try:
            return scenario, run_trials(scenario, source, population.trials, inputs=inputs)
        except FloatingPointError as error:
            raise RunError(f"a trial near failure cannot be computed: {error}") from error

    def __call__(self, population: StrataView) -> TrialMargins:
        """Return how near each trial came to each way to fail."""
        scenario, trials = self.run(population)
        return self.margins_of(trials, margins(self.event, trials, scenario))

    def margins_of(self, trials: MissionTrials, by_way: Mapping[str, Array]) -> TrialMargins:
        """Put the margins of trials in the order of the ways."""
        failed = self.event.happens(trials.columns())
        return TrialMargins(np.array([by_way[way] for way in self.ways]).reshape(len(self.ways), failed.size), failed)

    def describe(self, population: StrataView, weights: Array) -> FailingTrials:
        """Run trials that fail again, and keep what was drawn in them and what came of it."""
        _, trials = self.run(population, inputs=True)
        failed, steps = weights > 0.0, np.full(trials.success.size, "", dtype=object)
        for step, fails in failures_by_step(trials).items():
            steps[fails] = str(step)
        return FailingTrials(
            weights=weights[failed],
            columns={name: values[failed] for name, values in trials.columns().items()},
            inputs=tuple(trials.inputs()),
            steps=steps.astype(str)[failed],
        )


def discrete_values(mission: Mission, means: Scenario) -> dict[Key, Sequence[DiscreteValue]]:
    """List the values of the mission's discrete quantities, by the key of the normal that each is drawn from.

    Those that are correlated with others are left out: their normals are mixed with the others' before they are drawn.
    """
    mixed = {name for pair in mission.correlated for name in pair.between}
    values: dict[Key, Sequence[DiscreteValue]] = {
        (means.stream_of(path), 0): [
            DiscreteValue(path, f"{value:g}", interval) for value, interval in quantity.intervals.items()
        ]
        for path, quantity in mission.quantities().items()
        if isinstance(quantity, (Choices, WhichHolds)) and path not in mixed
    }
    anchor = mission.vehicle.anchor if mission.vehicle is not None else None
    if anchor is not None and 0.0 < anchor.premature_flooding < 1.0:
        share = anchor.premature_flooding
        for moor in mission.moors:
            path = f"{moor.name}.premature_flooding"
            values[path, 0] = [DiscreteValue(path, "yes", (0.0, share)), DiscreteValue(path, "no", (share, 1.0))]
    if isinstance(means.recorded, Ensemble) and means.recorded.given is None:
        ends = np.minimum(np.cumsum([0.0, *means.recorded.weights]), 1.0)
        ends[-1] = 1.0
        values[_by_leg(MEMBER), 0] = [
            DiscreteValue(MEMBER, str(number), (float(ends[number]), float(ends[number + 1])))
            for number in range(len(ends) - 1)
        ]
    return values


def units_of_inputs(mission: Mission, names: Iterable[str]) -> dict[str, str]:
    """SI units of what was drawn, by name: as the mission's keys declare it, or of what is summed up over legs."""
    units = {}
    for name in names:
        of_legs, _, side = name.rpartition(".")
        summed = UNITS_OF_LEGS.get(of_legs.rpartition(".")[2]) if side in SIDES else None
        units[name] = summed or unit_of(name, mission.raw, type(mission))
    return units


VARIATION = 0.1
"""Coefficient of variation at which it ends, unless one is given."""


def variation_asked(precision: str | None) -> float:
    """Read the coefficient of variation: ``5%`` or ``0.05``."""
    if precision is None:
        return VARIATION
    try:
        value = float(precision.strip().removesuffix("%")) / (100.0 if precision.strip().endswith("%") else 1.0)
    except ValueError:
        value = math.nan
    if not 0.0 < value < 1.0:
        message = f"given {precision!r}, expected a coefficient of variation of the probability"
        raise InputError([Problem(message, key="precision", hint="such as 5%")])
    return value
