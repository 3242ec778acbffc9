"""What a mission file holds, section by section: its keys, what stands for its phases, and what its sections allow.

The section `effects`: effects of the catalogue with their parameters in SI, and explanations of which one holds.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Annotated, Generic, Literal, TypeVar

from pydantic import Field, ValidationInfo, field_validator
from typing_extensions import Doc

from missionplan.effects import CATALOGUE
from missionplan.errors import KeyPath, LocalProblem, did_you_mean, key_path, shown
from missionplan.mission.checks import Findings, check_effects, check_ranges
from missionplan.mission.checks.relations import check_relations
from missionplan.mission.includes import posterior_of
from missionplan.mission.quantity_paths import joined, phase_keys
from missionplan.mission.schema import FileSection, Identity, MissionSchema, Moment, ReadBy, V, all_invalid, invalid
from missionplan.mission.schema.effect_list import ONE_OF, EffectEntry, EffectList, Explanation, Learned, OneOf
from missionplan.mission.schema.manoeuvring import TransitionPhase
from missionplan.mission.schema.phases import MoorPhase, Navigation, Phase, PhaseEntry, TransitPhase
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.site import Site
from missionplan.mission.schema.sweep import CorrelationSection, MonteCarlo, OptimiseSection, Requirement, SweepSection
from missionplan.mission.schema.vehicle import EnergyBudget, Vehicle
from missionplan.mission.units import QuantityError, each_read
from missionplan.moments import moment_of
from missionplan.montecarlo.distributions import ROUNDING, Quantity, mean_of
from missionplan.montecarlo.posterior import PosteriorFile
from missionplan.montecarlo.streams import Correlation, correlation_problems

_T = TypeVar("_T")

EPOCH = "epoch"
"""Key of the date from which the phases of an effect count."""
_EXPLANATION = ("probability", "effects", "correlations")
_EACH = "each as `effect-id: {parameter: quantity}`"
_PROBABILITY = QuantityParser("", low=0.0, high=1.0, open_low=True, fixed=True)
_PAIR = "{between: [effect.parameter, effect.parameter], rho}"
_RHO = QuantityParser("", low=-1.0, high=1.0, fixed=True)


def read_effects(value: object) -> EffectList:
    """Read the list as a pydantic validator does.

    Raises PydanticCustomError with one `LocalProblem` in ``ctx['problems']`` for each key that is wrong.
    """
    if isinstance(value, EffectList):
        return value
    if not isinstance(value, list | tuple):
        raise invalid(f"expected a list of effects, {_EACH}")
    try:
        return EffectList(tuple(each_read(value, lambda index, item: _item(item, ("effects", index)))))
    except QuantityError as error:
        raise all_invalid(error.problems) from None


def _item(item: object, path: KeyPath) -> EffectEntry | OneOf:
    if isinstance(item, Mapping) and ONE_OF in item:
        if len(item) > 1:
            others = ", ".join(str(key) for key in item if key != ONE_OF)
            raise QuantityError(f"given {others} beside it, expected an item of its own", (ONE_OF,))
        value = item[ONE_OF]
        if not isinstance(value, list) or not value:
            raise QuantityError("expected a list of explanations, each {probability, effects}", (ONE_OF,))
        place = f"{key_path(path)}.{ONE_OF}"
        explanations = each_read(
            value, lambda number, item: _explanation(item, (*path, ONE_OF, number), (place, (number,))), (ONE_OF,)
        )
        total = sum(explanation.probability for explanation in explanations)
        if total > 1.0 + ROUNDING:
            raise QuantityError(f"the probabilities sum to {total:.6g}, expected at most 1", (ONE_OF,))
        return OneOf(place, tuple(explanations))
    return replace(_entry(item), path=path)


def _explanation(item: object, path: KeyPath, explanation: tuple[str, tuple[int, ...]]) -> Explanation:
    if not isinstance(item, Mapping):
        raise QuantityError(f"given {shown(item)}, expected an explanation: {{probability, effects}}")
    problems = [
        LocalProblem((str(key),), "unknown key", did_you_mean(str(key), _EXPLANATION))
        for key in item
        if key not in _EXPLANATION
    ]
    problems += [LocalProblem((key,), "missing") for key in _EXPLANATION[:2] if key not in item]
    probability = _read(problems, item, "probability", lambda value: mean_of(_PROBABILITY.parse(value))) or 0.0
    entries = _read(problems, item, "effects", lambda value: _held(value, (*path, "effects"), explanation)) or ()
    names = {f"{entry.effect}.{name}": value for entry in entries for name, value in entry.parameters.items()}
    correlations: tuple[Correlation, ...] = ()
    if entries:
        correlations = _read(problems, item, "correlations", lambda value: _correlations(value, names)) or ()
    if problems:
        raise QuantityError(problems)
    return Explanation(probability, entries, correlations)


def _read(
    problems: list[LocalProblem], item: Mapping[object, object], key: str, read: Callable[[object], _T]
) -> _T | None:
    """Read a key of a mapping; None where it has none, or a wrong one, whose problems are added."""
    if key not in item:
        return None
    try:
        return read(item[key])
    except QuantityError as error:
        problems += [problem.within((key,)) for problem in error.problems]
        return None


def _held(value: object, path: KeyPath, explanation: tuple[str, tuple[int, ...]]) -> tuple[EffectEntry, ...]:
    """Read the effects of an explanation."""
    if not isinstance(value, list) or not value:
        raise QuantityError(f"expected a list of effects, {_EACH}")
    effects: set[str] = set()

    def read(index: int, item: object) -> EffectEntry:
        if isinstance(item, Mapping) and ONE_OF in item:
            raise QuantityError("an explanation cannot hold explanations; write each combination", (ONE_OF,))
        entry = _entry(item)
        if entry.effect in effects:
            raise QuantityError("this explanation has the effect already", (entry.effect,))
        effects.add(entry.effect)
        return replace(entry, path=(*path, index), explanation=explanation)

    return tuple(each_read(value, read))


def _correlations(value: object, parameters: Mapping[str, Quantity]) -> tuple[Correlation, ...]:
    """Read the correlations of an explanation's parameters."""
    if not isinstance(value, list):
        raise QuantityError(f"given {shown(value)}, expected a list of {_PAIR}")
    correlations = each_read(value, lambda _, item: _correlation(item))
    if problems := correlation_problems(parameters, correlations):
        raise QuantityError(problems)
    return tuple(correlations)


def _correlation(item: object) -> Correlation:
    if not isinstance(item, Mapping) or set(item) != {"between", "rho"}:
        raise QuantityError(f"given {shown(item)}, expected {_PAIR}")
    between = item["between"]
    if not isinstance(between, list) or len(between) != 2 or not all(isinstance(name, str) for name in between):
        raise QuantityError(f"given {shown(between)}, expected two of the explanation's parameters", ("between",))
    try:
        return Correlation((between[0], between[1]), mean_of(_RHO.parse(item["rho"])))
    except QuantityError as error:
        raise QuantityError([problem.within(("rho",)) for problem in error.problems]) from None


def _entry(item: object) -> EffectEntry:
    """Read one effect.

    Raises QuantityError with every key that is wrong.
    """
    if not isinstance(item, Mapping) or len(item) != 1 or not isinstance(next(iter(item.values())), Mapping):
        raise QuantityError("expected one effect in each item, as `effect-id: {parameter: quantity}`")
    ((effect, section),) = item.items()
    if effect not in CATALOGUE:
        hint = did_you_mean(str(effect), [*CATALOGUE, ONE_OF], before="; ")
        raise QuantityError(f"no effect of that name{hint}", (effect,))
    problems: list[LocalProblem] = []
    has_epoch = CATALOGUE[effect].frequency_of is not None
    epoch = _read(problems, section, EPOCH, _date) if has_epoch else None
    parameters: dict[str, Quantity] = {}
    for name in section:
        if name != EPOCH or not has_epoch:
            value = _read(problems, section, name, partial(_parameter, effect, name))
            parameters |= {} if value is None else {name: value}
    if problems:
        raise QuantityError([problem.within((effect,)) for problem in problems])
    return EffectEntry(effect, parameters, epoch=epoch)


def _date(text: object) -> float:
    """Read a date [s since 1970]."""
    try:
        return moment_of(text).timestamp()
    except (ValueError, OverflowError, TypeError):
        raise QuantityError(f"given {shown(text)}, expected a date such as 2026-06-01T04:00Z") from None


def _parameter(effect: str, name: str, text: object) -> Quantity:
    parameters = CATALOGUE[effect].parameters
    if name not in parameters:
        hint = did_you_mean(str(name), parameters, before="; ")
        raise QuantityError(f"{effect} has no such parameter; it has {', '.join(parameters)}{hint}")
    return QuantityParser(parameters[name].unit, low=parameters[name].low, high=parameters[name].high).parse(text)


MOST_LEARNED = 5000
"""Legs, dives and runs that a mission keeps in mind, the last ones: half of what a file may hold."""


class Sections(FileSection, Generic[V]):
    """The sections of a mission file. All in SI; quantities are floats or distributions; drawn, floats or arrays."""

    file_schema: MissionSchema = Field(default="missionplan/mission/1", alias="schema")
    name: Annotated[str, Doc("name of the mission, for reports"), Field(examples=["Saanich, spring"])] = ""
    start: Annotated[Moment | None, Doc("time at which the mission begins, UTC")] = None
    units: Annotated[
        Literal["metric", "nautical", "imperial"] | None,
        Doc("units in which reports are written; without it those of the file"),
    ] = None
    vehicle: Annotated[Vehicle[V] | None, Doc("the vehicle, or the name of its file")] = None
    site: Annotated[Site[V] | None, Doc("water, ground and currents where it goes")] = None
    navigation: Annotated[Navigation[V] | None, Doc("how well the vehicle knows where it is")] = None
    entries: Annotated[tuple[PhaseEntry[V], ...], Doc("what the vehicle does, in order")] = Field(
        default=(), alias="phases"
    )
    sweep: Annotated[SweepSection, Doc("what `sweep-dmax` varies")] = SweepSection()
    optimise: Annotated[OptimiseSection, Doc("what `optimise` may choose")] = OptimiseSection()
    monte_carlo: Annotated[MonteCarlo, Doc("number of trials and seed")] = MonteCarlo()
    energy: Annotated[EnergyBudget[V] | None, Doc("energy that is drawn and carried; over the vehicle's")] = None
    requirements: Annotated[tuple[Requirement, ...], Doc("what has to hold, with its probability")] = ()
    correlations: Annotated[tuple[CorrelationSection, ...], Doc("quantities that are drawn together")] = ()
    effect_list: Annotated[EffectList[V], ReadBy(read_effects), Doc("effects of the catalogue that act")] = Field(
        default=EffectList(), alias="effects"
    )
    posterior: Annotated[
        PosteriorFile | None, ReadBy(posterior_of), Doc("what a diagnosis has learned, beside the mission")
    ] = None
    learned_from: Annotated[
        tuple[Identity, ...],
        Field(max_length=MOST_LEARNED, examples=[["0123456789abcdef"]]),
        Doc("hashes of what the effects were learned from, as diagnose writes them"),
    ] = ()

    @field_validator("entries", mode="after")
    @classmethod
    def _key_phases(cls, entries: tuple[PhaseEntry, ...]) -> tuple[PhaseEntry, ...]:
        keys = phase_keys([entry.phase.label for entry in entries])
        return tuple(entry.keyed(key) for entry, key in zip(entries, keys, strict=True))

    @field_validator("sweep", mode="after")
    @classmethod
    def _resolve_phase(cls, sweep: SweepSection, info: ValidationInfo) -> SweepSection:
        keys = {entry.phase.label: entry.phase.name for entry in info.data.get("entries", ())}
        return sweep.model_copy(update={"phase": keys.get(sweep.phase, sweep.phase)})

    @field_validator("requirements", "correlations", mode="after")
    @classmethod
    def _resolve_names(
        cls, sections: tuple[Requirement | CorrelationSection, ...], info: ValidationInfo
    ) -> tuple[Requirement | CorrelationSection, ...]:
        names = [entry.phase.label for entry in info.data.get("entries", ())]
        return tuple(section.resolved(names) for section in sections)

    @property
    def phases(self) -> "tuple[Phase[V], ...]":
        """Phases in the order of the file."""
        return tuple(entry.phase for entry in self.entries)

    @property
    def transits(self) -> tuple[TransitPhase[V], ...]:
        """The transits among the phases."""
        return tuple(phase for phase in self.phases if isinstance(phase, TransitPhase))

    @property
    def moors(self) -> tuple[MoorPhase[V], ...]:
        """The moorings among the phases."""
        return tuple(phase for phase in self.phases if isinstance(phase, MoorPhase))

    @property
    def transitions(self) -> tuple[TransitionPhase[V], ...]:
        """The transitions among the phases."""
        return tuple(phase for phase in self.phases if isinstance(phase, TransitionPhase))

    @property
    def effects(self) -> tuple[EffectEntry[V], ...]:
        """Every effect of the mission, those of its explanations too."""
        return self.effect_list.entries

    @property
    def doubts(self) -> tuple[OneOf[V] | Learned[V], ...]:
        """Lists of explanations of which one holds, and the posterior."""
        return self.effect_list.doubts

    @property
    def correlated(self) -> tuple[Correlation, ...]:
        """Correlations of the mission and of its explanations."""
        inside = [correlation for doubt in self.doubts for correlation in doubt.correlations()]
        return (*(section.pair for section in self.correlations), *inside)

    @property
    def budget(self) -> EnergyBudget[V] | None:
        """Energy budget in force, key by key: the mission's, else the vehicle's, else the default."""
        return joined(self.energy, self.vehicle.energy if self.vehicle else None)

    def _limits(self: "Sections") -> Findings:
        """List what the world does not allow, and what is unusual."""
        sections = [
            (name, value) for name, value in self if name not in ("entries", "effect_list", "optimise", "posterior")
        ]
        return (
            check_ranges(sections, self.phases)
            + check_effects(self.effects)
            + check_relations(self.phases, self.site, self.vehicle, self.navigation, self.energy)
        )
