"""Dive logs beside the catalogue of causes: readings in one vector, coordinates of all causes and their priors."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate, coordinates_of
from missionplan.diagnosis.dives.forward import DescentForward
from missionplan.diagnosis.given.effects import GivenEffect, coordinate_prior, held, places_in
from missionplan.diagnosis.inference.prior import Prior
from missionplan.effects import effects_of, named_effects
from missionplan.results.learned.evidence import Causes


@dataclass(frozen=True)
class DescentPriors:
    """The d dives of a data set with k coordinates of all causes, each under a spike-and-slab prior."""

    forward: DescentForward
    """The descent phase, bound to the dives."""
    given: tuple[GivenEffect, ...] = ()
    """The mission's own effects, whose parameters are fitted under what the mission knows of them."""

    @cached_property
    def candidates(self) -> Causes:
        """Effects of the catalogue on a descent, those without a name where these dives differ in what they follow."""
        return (*(info.id for info in named_effects("descent")), *self.unnamed)

    @cached_property
    def unnamed(self) -> Mapping[str, tuple[str, str]]:
        """Effects without a name: what each follows, and in words."""
        differs = {"depth", "speed", "time"}
        if len({log.line_length for log in self.forward.logs}) > 1:
            differs.add("line")
        return {info.id: (info.follows, info.what) for info in effects_of("descent") if info.follows in differs}

    @property
    def untestable(self) -> Mapping[str, str]:
        """None: every effect on a descent can show in a dive log."""
        return {}

    @cached_property
    def y(self) -> Array:
        """Readings of all dives, one dive after the other, shape (N,) [m]."""
        return np.concatenate([log.depth for log in self.forward.logs])

    @cached_property
    def parts(self) -> tuple[NDArray[np.int_], ...]:
        """Rows of each dive."""
        lengths = [len(log.t) for log in self.forward.logs]
        return tuple(np.split(np.arange(sum(lengths)), np.cumsum(lengths)[:-1]))

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of all causes."""
        return tuple(c for info in effects_of("descent") for c in coordinates_of(info))

    @cached_property
    def centre(self) -> Array:
        """Prior means of the coordinates of effects that the mission does not have, shape (k,)."""
        return np.array([coordinate.centre for coordinate in self.coordinates])

    @cached_property
    def slab(self) -> Array:
        """Prior standard deviations of the coordinates as causes, shape (k,)."""
        return np.array([coordinate.slab for coordinate in self.coordinates])

    @cached_property
    def expected(self) -> Array:
        """Coordinates that the mission expects: those of its own effects, the centres of the others, shape (k,)."""
        return self.prior(()).centre

    def prior(self, causes: Causes) -> Prior:
        """Prior of the coordinates."""
        return coordinate_prior(self.coordinates, causes, self.given)

    def prior_sd(self, causes: Causes) -> Array:
        """Prior standard deviations, those of the slabs at their usual scale, shape (k,)."""
        return self.prior(causes).sd

    def nuisance_sd(self, causes: Causes) -> Array:
        """Prior standard deviations of all coordinates but those that are searched, which have 0, shape (k,)."""
        sd = self.prior_sd(causes)
        sd[self.searched(causes)] = 0.0
        return sd

    def free(self, causes: Causes) -> NDArray[np.int_]:
        """Coordinates of the causes."""
        return np.flatnonzero([coordinate.effect in causes for coordinate in self.coordinates])

    def searched(self, causes: Causes) -> NDArray[np.int_]:
        """Coordinates of the causes and of the mission's own effects, about whose best values a fit is linearised."""
        own = [i for each in held(self.given, causes) for i in places_in(self.coordinates, each)]
        return np.union1d(self.free(causes), np.array(own, dtype=int))

    def index(self, effect: str) -> int:
        """First coordinate of an effect."""
        return [coordinate.effect for coordinate in self.coordinates].index(effect)
