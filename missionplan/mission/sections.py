"""What a mission file holds, section by section: its keys, what stands for its phases, and what its sections allow."""

from typing import Annotated, Generic, Literal

from pydantic import Field, ValidationInfo, field_validator
from typing_extensions import Doc

from missionplan.errors import LocalProblem
from missionplan.mission.checks.ranges import Findings, check_effects, check_ranges
from missionplan.mission.checks.relations import check_relations
from missionplan.mission.quantity_paths import joined, phase_keys
from missionplan.mission.reading.includes import posterior_of
from missionplan.mission.schema.effect_list import EffectEntry, EffectList, Learned, OneOf
from missionplan.mission.schema.effects import read_effects
from missionplan.mission.schema.phases import MoorPhase, Navigation, Phase, PhaseEntry, TransitPhase
from missionplan.mission.schema.section import FileSection, Identity, MissionSchema, Moment, ReadBy, V
from missionplan.mission.schema.site import Site
from missionplan.mission.schema.sweep import CorrelationSection, MonteCarlo, OptimiseSection, Requirement, SweepSection
from missionplan.mission.schema.transition import TransitionPhase
from missionplan.mission.schema.vehicle import EnergyBudget, Vehicle
from missionplan.montecarlo.draws import Correlation
from missionplan.montecarlo.posterior_file import PosteriorFile

MOST_LEARNED = 5000
"""Legs, dives and runs that a mission keeps in mind, the last ones: half of what a file may hold."""


class Sections(FileSection, Generic[V]):
    """The sections of a mission file. All in SI; quantities are floats or distributions; drawn, floats or arrays."""

    file_schema: MissionSchema = Field(default="missionplan/mission/1", alias="schema")
    name: Annotated[str, Doc("name of the mission, for reports")] = ""
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
    effect_list: Annotated[EffectList[V], Doc("effects of the catalogue that act")] = Field(
        default=EffectList(), alias="effects"
    )
    posterior: Annotated[
        PosteriorFile | None, ReadBy(posterior_of), Doc("what a diagnosis has learned, beside the mission")
    ] = None
    learned_from: Annotated[
        tuple[Identity, ...],
        Field(max_length=MOST_LEARNED),
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

    @field_validator("effect_list", mode="plain")
    @classmethod
    def _read_effects(cls, value: object) -> EffectList:
        return read_effects(value)

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

    def _undated(self: "Sections") -> list[LocalProblem]:
        """List the effects whose phases count from a date, in a mission without one."""
        words = "the mission has no start, which the date of these phases needs"
        return [LocalProblem((*e.path, e.effect, "epoch"), words) for e in self.effects if e.epoch is not None]

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
