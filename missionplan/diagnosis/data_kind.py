"""What the diagnosis asks of a kind of data, and the kinds: a new one has a folder of its own and a line in `KINDS`."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Protocol, Self, cast

import pandas as pd

from missionplan.datasets import dataset_kind
from missionplan.datasets.records import HasIdentities, is_learned
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.given import GivenEffect
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.selection import Selection, WeighsAllSets
from missionplan.diagnosis.plan_gain import anchor_choice, plan_gain
from missionplan.mission import Mission
from missionplan.montecarlo.posterior import NOWHERE, Place
from missionplan.results.learned import PlanGain
from missionplan.results.learned.evidence import Alias, Causes, ParameterEstimate, Verdict, WrongFix


class Dataset(HasIdentities, Protocol):
    """What every data set has."""

    @property
    def name(self) -> str:
        """Its name."""
        ...

    @property
    def source(self) -> str:
        """Where it comes from."""
        ...

    @property
    def notices(self) -> tuple[str, ...]:
        """Treatments the reader should know of."""
        ...

    @property
    def date(self) -> float:
        """When they were taken [s since 1970]; nan where they do not tell."""
        ...


class BoundModel(WeighsAllSets, Protocol):
    """Base model and catalogue, bound to a data set."""

    @property
    def given(self) -> tuple[GivenEffect, ...]:
        """The mission's own effects, those that the data could show."""
        ...


PutOff = tuple[str, str, BoundModel]
"""What is taken as exact, what is put in its place, and the model then."""


class DataKind(ABC):
    """A kind of measured data; an instance is one data set of the kind, bound to a mission."""

    kind: str
    """``kind`` in ``dataset.yaml``, one of `KINDS`."""
    mission: Mission
    """The base model."""
    data: Dataset
    """What was read."""
    model: BoundModel
    """Base model and catalogue, bound to the data."""

    @property
    def is_known(self) -> bool:
        """Whether the mission has learned from all of these data: they teach it nothing more."""
        return bool(is_learned(self.data, self.mission.learned_from).all())

    @property
    def model_coordinates(self) -> Sequence[Coordinate]:
        """Parameters of all causes as the model fits them; none where trials are not designed from such data."""
        return ()

    @property
    def given(self) -> tuple[GivenEffect, ...]:
        """The mission's own effects, those that the data could show."""
        return self.model.given

    @property
    def places(self) -> tuple[Place, ...]:
        """Where and when the data were taken; else what the mission has learned so far."""
        return (NOWHERE,) if self.mission.posterior is None else self.mission.posterior.places

    @property
    def date(self) -> float:
        """When the data were taken [s since 1970]; nan where they do not tell."""
        return self.data.date

    @property
    def known(self) -> tuple[ParameterEstimate, ...]:
        """What the mission knows of them."""
        return tuple(estimate for prior in self.given for estimate in prior.prior)

    @classmethod
    @abstractmethod
    def bind(cls, kind: str, folder: Path, mission: Mission, seed: int) -> Self:
        """Read a data set and bind a mission to it.

        `kind` is one of `KINDS`; `seed` of draws from the mission's own uncertainty, where the model needs them.

        Raises InputError: all problems of the data set, or all that the mission lacks.
        """

    @abstractmethod
    def residual_table(self, base: CauseFit, best: CauseFit) -> pd.DataFrame:
        """Return one row a datum: measured, as the base and as the extended model have it, and what is left."""

    @abstractmethod
    def misfit(self, residuals: pd.DataFrame) -> str:
        """Describe the size of the base model's misfit in the planner's terms; `residuals` as by `residual_table`."""

    @abstractmethod
    def shares_explained(self, base: CauseFit, fits: Sequence[CauseFit], residuals: pd.DataFrame) -> list[float]:
        """Return the share of the base model's squared residuals that goes with each fit."""

    def extended_mission(self, best: CauseFit) -> dict[str, object]:
        """Return the mission file's data with what a fit says of all that belongs to no effect."""
        return dict(self.mission.raw)

    def plan_gain(self, base: Mission, extended: Mapping[str, object], *, seed: int, jobs: int) -> PlanGain:
        """Return what the planner would choose with the mission given and with the extended one: as a rule an anchor.

        See `plan_gain`.
        """
        return plan_gain(anchor_choice, base, extended, seed=seed, jobs=jobs)

    def calibration(self, best: CauseFit) -> dict[str, float]:
        """Return the base model's nuisance parameters as fitted, and what else the reader may set beside them."""
        return dict(best.calibration)

    def carried(self, best: CauseFit, scale: float) -> CauseFit:
        """Return a fit as a mission's effects carry it: random errors scaled, without what its other keys state."""
        return best

    def not_constant(self, best: CauseFit) -> Causes:
        """Return the causes of a fit that do not hold still over the record."""
        return ()

    def put_off(self) -> Iterator[PutOff]:
        """Yield what the data set takes as exact, what is put in its place, and the model then."""
        yield from ()

    def aliases(self, best: CauseFit) -> tuple[Alias, ...]:
        """Return effects that do to these data what a claimed cause does, but not on the way back."""
        return ()

    def is_better_ahead(self, base: CauseFit, best: CauseFit) -> bool:
        """Whether a fit to the first part of the record predicts the rest all the way better than the base model."""
        return True

    def suspect_labels(self, selection: Selection) -> str:
        """Say which labels of the record are likely to be wrong; else empty."""
        return ""

    def wrong_fixes(self, best: CauseFit) -> tuple[WrongFix, ...]:
        """Return the GPS fixes that are wrong."""
        return ()

    def confounded_with_reckoning(self, best: CauseFit) -> Causes:
        """Return causes of a fit that the doubt of a made dead reckoning may be all of."""
        return ()

    def limited_verdict(self, verdict: Verdict) -> Verdict:
        """Return the verdict, or a weaker one where data of this kind cannot support it."""
        return verdict


KINDS: Mapping[str, tuple[str, str]] = {
    "transit": ("missionplan.diagnosis.legs.kind", "TransitKind"),
    "descent": ("missionplan.diagnosis.dives.kind", "DescentKind"),
    "drag": ("missionplan.diagnosis.tank.kind", "TankKind"),
    "free-oscillation": ("missionplan.diagnosis.tank.kind", "TankKind"),
    "thruster": ("missionplan.diagnosis.tank.kind", "TankKind"),
    "propeller-transient": ("missionplan.diagnosis.tank.kind", "TankKind"),
    "summary": ("missionplan.diagnosis.summaries", "SummaryKind"),
}
"""By ``kind`` in ``dataset.yaml``, the module and the class: one of them is imported, when it is needed."""


def kind_named(name: str) -> type[DataKind]:
    """Import a kind of data by its name in ``dataset.yaml``."""
    module, of = KINDS[name]
    return cast("type[DataKind]", getattr(import_module(module), of))


def bind_dataset(folder: Path, mission: Mission, seed: int) -> DataKind:
    """Read a data set of any kind and bind a mission to it.

    ``dataset.yaml`` of the folder says which kind it is; `seed` is of draws from the mission's own uncertainty.

    Raises InputError when there is no such kind; all problems of the data set, or all that the mission lacks.
    """
    kind = dataset_kind(folder, KINDS)
    return kind_named(kind).bind(kind, folder, mission, seed)
