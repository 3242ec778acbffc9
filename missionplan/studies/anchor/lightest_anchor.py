"""The lightest anchor that does all that is asked of its dive, or what stands against what."""

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from missionplan.report.wording import beside, portion_in_words
from missionplan.results.sized_anchor import DiveProbabilities

MAX_WEIGHT_RATIO = 10.0
"""Heaviest anchor tried over the worst-case one; it sinks three times as fast, so that drift before the descent is
what is left."""
_LIGHTEST_RATIO = 1000.0
"""The worst-case anchor over the lightest tried, where all from a tenth of the worst-case one on meet the demands."""
MAX_LINE_RATIO = 20.0
"""Longest line tried over the given one."""
_STEPS = 6
"""Intervals into which the weights are divided before the search, a factor of two each."""
_NARROW = 1.2
"""Ratio of weights within which a hill, whose height both ends miss, is not looked for."""
_NEAR = 1.25
"""Factor about what few dives find within which many are looked for: their lightest differs by some percent."""
_RESOLUTION = 1.001
_LINE_RESOLUTION = 1.02

ProbabilitiesOf = Callable[[float, float | None], DiveProbabilities]
"""Probabilities of a wet weight [N] with a line [m], None for the mission's own."""


@dataclass(frozen=True)
class Demand:
    """Something that dives have to do so often."""

    words: str
    required: float
    share: Callable[[DiveProbabilities], float]
    """How often they do."""
    needs_height: bool = False
    """Whether a longer line helps."""
    is_hill: bool = False
    """Whether the share may rise with the weight and then fall; else it does one of both."""

    def slack(self, odds: DiveProbabilities) -> float:
        """Share of the dives less that required."""
        return self.share(odds) - self.required


@dataclass(frozen=True)
class LightestAnchor:
    """Result of the search."""

    weight: float | None
    """Lightest wet weight that does all that is asked [N]."""
    compromise: float
    """Weight that comes nearest to it; the same where there is one [N]."""
    reason: str = ""
    """Which demand stands against which where there is none; empty otherwise."""
    line_length: float | None = None
    line_weight: float | None = None
    """Shortest line with which an anchor does, and the anchor's wet weight [m, N]."""


def lightest_anchor(
    probabilities: ProbabilitiesOf,
    demands: Sequence[Demand],
    start: float,
    line_length: float,
    rough: ProbabilitiesOf | None = None,
) -> LightestAnchor:
    """Search wet weights for the lightest that meets all demands.

    On common random numbers (Law 2015, Simulation Modeling and Analysis, sect. 11.2) most shares only rise with the
    weight, as that of dives within the radius, or only fall, as that of dives clear of the seafloor: where both ends of
    an interval miss such a demand, so does all between them. Other intervals are halved.

    `start`: wet weight about which to search, such as the worst case's [N]. `line_length`: the mission's [m]. `rough`:
    of fewer dives, which say where to look, and for the search of a longer line; default: the same.
    """
    tried = _Tried(probabilities, demands, None, _RESOLUTION)
    about = _Tried(rough, demands, None, _RESOLUTION).lightest(start) if rough is not None else None
    weight = tried.lightest_about(about) if about is not None else None
    weight = tried.lightest(start) if weight is None else weight
    if weight is not None:
        return LightestAnchor(weight, weight)
    compromise = tried.compromise()
    lightest = LightestAnchor(None, compromise, tried.why_none(compromise))
    if not tried.could_do_with_height():
        return lightest
    line, weight = _shortest_line(rough or probabilities, demands, start, line_length)
    if line is None:
        return replace(lightest, reason=f"{lightest.reason}; no line up to {MAX_LINE_RATIO:g} times as long helps")
    return replace(lightest, line_length=line, line_weight=weight)


@dataclass
class _Tried:
    """Weights with one line, and what each leaves of every demand."""

    probabilities: ProbabilitiesOf
    demands: Sequence[Demand]
    line: float | None
    resolution: float
    known: dict[float, DiveProbabilities] = field(default_factory=dict)

    def slacks(self, weight: float) -> list[float]:
        """Share of the dives less that required, of each demand."""
        if weight not in self.known:
            self.known[weight] = self.probabilities(weight, self.line)
        return [demand.slack(self.known[weight]) for demand in self.demands]

    def lightest(self, start: float) -> float | None:
        """Lightest weight [N] that meets all demands, up to ten times a weight; None where none does."""
        grid = np.geomspace(start / MAX_WEIGHT_RATIO, start * MAX_WEIGHT_RATIO, _STEPS + 1).tolist()
        while grid[0] > start / _LIGHTEST_RATIO and self._lighter_may_do(grid):
            grid.insert(0, 0.5 * grid[0])
        weights = (self._within(light, heavy) for light, heavy in itertools.pairwise(grid))
        return next((weight for weight in weights if weight is not None), None)

    def _lighter_may_do(self, grid: Sequence[float]) -> bool:
        """Whether one below the lightest may be wanted: it meets all, or no heavier one misses less of what it misses.

        Another line than the mission's is for heavier anchors: there the first alone counts.
        """
        lightest = self.slacks(grid[0])
        if self.line is not None or min(lightest) >= 0.0:
            return min(lightest) >= 0.0
        heavier = (self.slacks(weight) for weight in grid[1:])
        return not any(one < min(0.0, other) for others in heavier for one, other in zip(lightest, others, strict=True))

    def lightest_about(self, weight: float) -> float | None:
        """Lightest weight [N] that meets all demands, near one that fewer dives found; None where it is not near."""
        grid = np.geomspace(weight / _NEAR, weight * _NEAR, 7).tolist()
        if min(self.slacks(grid[0])) >= 0.0:
            return None
        weights = (self._within(light, heavy) for light, heavy in itertools.pairwise(grid))
        return next((weight for weight in weights if weight is not None), None)

    def _within(self, light: float, heavy: float) -> float | None:
        below, above = self.slacks(light), self.slacks(heavy)
        if min(below) >= 0.0:
            return light
        is_narrow = heavy <= light * _NARROW
        for demand, one, other in zip(self.demands, below, above, strict=True):
            if one < 0.0 and other < 0.0 and (is_narrow or not demand.is_hill):
                return None
        if heavy <= light * self.resolution:
            return heavy if min(above) >= 0.0 else None
        middle = math.sqrt(light * heavy)
        lighter = self._within(light, middle)
        return self._within(middle, heavy) if lighter is None else lighter

    def compromise(self) -> float:
        """Weight whose worst demand is missed by least [N]; of equal ones the nearest to all, then the lightest."""

        def worst(weight: float) -> tuple[float, float, float]:
            return min(self.slacks(weight)), sum(min(slack, 0.0) for slack in self.slacks(weight)), -weight

        for _ in range(6):
            weights = sorted(self.known)
            place = weights.index(max(weights, key=worst))
            for light, heavy in itertools.pairwise(weights[max(place - 1, 0) : place + 2]):
                self.slacks(math.sqrt(light * heavy))
        return max(self.known, key=worst)

    def could_do_with_height(self) -> bool:
        """Whether dives are too low, or strike where they would otherwise do what is asked."""
        too_low = (
            item.required - odds.struck.value <= item.share(odds) < item.required
            for odds in self.known.values()
            for item in self.demands
        )
        return any(item.needs_height for item in self.demands) or any(too_low)

    def why_none(self, compromise: float) -> str:
        """Write which demand no weight meets, or which need more than others allow, and what the compromise does."""
        strictest = {demand.words: demand for demand in sorted(self.demands, key=lambda demand: demand.required)}
        demands, weights = list(strictest.values()), sorted(self.known)
        met = [[weight for weight in weights if demand.slack(self.known[weight]) >= 0.0] for demand in demands]
        never = [demand for demand, some in zip(demands, met, strict=True) if not some]
        if never:
            words = "; ".join(self._at_best(demand) for demand in never)
            if all(odds.within.value < min(demand.required for demand in never) for odds in self.known.values()):
                within = max(odds.within.value for odds in self.known.values())
                drift = "come down within the radius at best: drift before the line is taut"
                words += f"; {portion_in_words(within, 1)} {drift}"
        else:
            low = max(range(len(met)), key=lambda number: met[number][0])
            high = min(range(len(met)), key=lambda number: met[number][-1])
            words = (
                f"{demands[low].words} asks for {met[low][0]:.3g} N or more, {demands[high].words} for "
                f"{met[high][-1]:.3g} N or less"
            )
        shares = ", ".join(
            f"{demand.words} in {beside(demand.share(self.known[compromise]), demand.required)} of dives "
            f"({100.0 * demand.required:g} % asked)"
            for demand in demands
        )
        return f"{words}. The best compromise, {compromise:.3g} N: {shares}"

    def _at_best(self, demand: Demand) -> str:
        shares = {weight: demand.share(odds) for weight, odds in sorted(self.known.items())}
        weight = max(shares, key=lambda weight: (shares[weight], -weight))
        most = beside(shares[weight], demand.required)
        if len(shares) > 1 and len({*shares.values()}) == 1:
            return f"{demand.words} in {most} of dives, whatever the anchor weighs"
        return f"{demand.words} in {most} of dives at best, with {weight:.3g} N"


def _shortest_line(
    probabilities: ProbabilitiesOf, demands: Sequence[Demand], start: float, line_length: float
) -> tuple[float | None, float | None]:
    """Shortest line with which an anchor meets all demands, and its wet weight; None where none does."""
    weights: dict[float, float | None] = {}

    def is_enough(length: float) -> bool:
        weights[length] = _Tried(probabilities, demands, length, _LINE_RESOLUTION).lightest(start)
        return weights[length] is not None

    length = line_length
    while not is_enough(length):
        length *= 1.5
        if length > line_length * MAX_LINE_RATIO:
            return None, None
    low = length / 1.5
    while length > low * _LINE_RESOLUTION:  # the logarithm is halved (Press et al. 2007, sect. 9.1)
        middle = math.sqrt(low * length)
        low, length = (low, middle) if is_enough(middle) else (middle, length)
    return length, weights[length]
