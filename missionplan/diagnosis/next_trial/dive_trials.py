"""Dives as trials: anchors and lines in stock, lighter anchors, longer lines, deeper places."""

import copy
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import cast

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.dives import DiveConditions
from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.dives.designs import stretched_dives, with_depths
from missionplan.diagnosis.dives.fitting import DescentState
from missionplan.diagnosis.dives.kind import DescentKind
from missionplan.diagnosis.dives.noise import SCATTER_FACTORS, Noise, noise_grid, shape_error_covariance
from missionplan.diagnosis.dives.preparation import DiveLog
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.next_trial.belief import Believed, Posterior
from missionplan.diagnosis.next_trial.designs import Alternatives, Cost, TrialKind, cost_of
from missionplan.diagnosis.next_trial.prediction import Prediction
from missionplan.diagnosis.plan_gain import with_anchor
from missionplan.mission.schema.phases import MoorPhase
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.montecarlo.distributions import mean_of
from missionplan.studies.anchor import worst_case_anchor

NEGLIGIBLE = 0.02
"""Probability below which a noise is not considered."""


def planned(logs: tuple[DiveLog, ...], belief: Believed) -> Prediction:
    """Return what dives to come show under a set of causes: as `made`, of the depths that the set expects."""
    model = cast("DescentKind", belief.bound).model
    readings = replace(model.forward, logs=logs).readings(model.coordinates, belief.posterior.mean[:, None])
    (prediction,) = made(with_depths(logs, readings[:, 0]), [belief])
    return prediction


def made(logs: tuple[DiveLog, ...], believed: Sequence[Believed]) -> list[Prediction]:
    """Mean, sensitivities and everything else of dives under sets of causes of one mission.

    The phase is linearised at the parameters' mean and about each log's most likely release delay, as where a log is
    fitted. What the causes add is uncertain by a smooth factor, as in a fit, but one that all these dives share, for
    their law has the same error in each; and by how much dives scatter is known only so far as the dives so far tell.

    All sets have data bound to the mission under the same explanation.
    """
    model = cast("DescentKind", believed[0].bound).model
    model = replace(model, forward=replace(model.forward, logs=logs))
    linears = model.linearise([(belief.fit.causes, belief.posterior.mean) for belief in believed])
    without = np.stack([belief.posterior.mean for belief in believed], axis=1)  # causes and the mission's own effects
    for number, belief in enumerate(believed):
        places = [place for place in belief.posterior.places if model.coordinates[place].kind != "shape"]
        without[places, number] = 0.0
    delays = np.stack([linear.release_delays for linear in linears])
    bare = model.forward.readings(model.coordinates, without, delays)
    spikes = np.array([coordinate.spike for coordinate in model.coordinates])
    times, predictions = np.concatenate([log.t for log in model.forward.logs]), []
    for belief, linear, depths in zip(believed, linears, bare.T, strict=True):
        added = linear.readings - depths
        shared, plain = shape_error_covariance(times, added), replace(linear, shaped=np.zeros_like(added))
        noises, shares = _noises(belief.fit.state)
        covariances = [model.covariance(plain, noise, spikes).dense() + shared for noise in noises]
        centre = linear.readings - model.release_delay_shift(linear)
        predictions.append(
            Prediction(centre, linear.columns[:, belief.posterior.places], np.stack(covariances), shares)
        )
    return predictions


def _noises(state: DescentState) -> tuple[list[Noise], Array]:
    """The likeliest noise at each scatter from dive to dive, and their probabilities by the dives so far."""
    grid, logs = noise_grid(), state.likelihood.log_joint(state.prior_sd)
    shares = np.exp(logs - np.logaddexp.reduce(logs))
    noises = []
    for scatter in SCATTER_FACTORS:
        indices = [index for index, noise in enumerate(grid) if noise.scatter == scatter]
        noises.append((grid[max(indices, key=lambda index: shares[index])], float(shares[indices].sum())))
    kept = [(noise, share) for noise, share in noises if share > NEGLIGIBLE]
    total = sum(share for _, share in kept)
    return [noise for noise, _ in kept], np.array([share / total for _, share in kept])


COUNTS = (2, 4)
"""Dives of a trial."""
STOCK = 4
"""Anchors and lines of the dives so far that are tried again, at most."""
LIGHT, LONG, DEEP = 0.4, 3.0, 2.0
"""Factors on anchor, line and depth of trials with what may not be in stock, where the mission does not say what is."""
FACTORS = np.array([0.5, 0.65, 0.8, 1.0, 1.25, 1.5, 1.8, 2.2, 2.6])
"""Anchors that may be chosen, over the mission's, where it does not say what is in stock."""


@dataclass(frozen=True)
class _Dives:
    """Dives of a trial, all in one place."""

    name: str
    dives: tuple[DiveConditions, ...]


@dataclass(frozen=True)
class DiveTrials(TrialKind):
    """Dives that the mission's vehicle could make."""

    bound: DescentKind
    """The dives so far, bound to the mission."""

    @cached_property
    def _moor(self) -> MoorPhase:
        return self.bound.mission.moors[0]

    @cached_property
    def _logs(self) -> tuple[DiveLog, ...]:
        return self.bound.model.forward.logs

    @cached_property
    def _plans(self) -> tuple[_Dives, ...]:
        """Dives with what is in stock, then with what may have to be made or reached; those at a place that differ."""
        used = dict.fromkeys(DiveConditions(log.wet_weight, log.line_length, log.site_depth) for log in self._logs)
        stock = list(used)[:STOCK]
        first = stock[0]
        weights = self._in_stock("anchor_wet_weight", "N") or (LIGHT * first.wet_weight,)
        lines = self._in_stock("line_length", "m") or (LONG * first.line_length,)
        others = {
            f"an anchor of {weight:.3g} N": replace(first, wet_weight=weight)
            for weight in weights
            if weight not in {dive.wet_weight for dive in stock}
        }
        others |= {
            f"a line of {line:.3g} m": replace(
                first, line_length=line, site_depth=first.site_depth + line - first.line_length
            )
            for line in lines
            if line not in {dive.line_length for dive in stock}
        }
        deep = DEEP * first.site_depth
        others[f"{deep:.3g} m of water"] = replace(first, site_depth=deep)
        named_stock = {f"{dive.wet_weight:.3g} N on {dive.line_length:.3g} m of line": dive for dive in stock}
        plans = [
            _Dives(f"{_counted(count)} with {what}", (dive,) * count)
            for count in COUNTS
            for what, dive in (named_stock | others).items()
        ]
        return tuple(plans)

    def _in_stock(self, key: str, unit: str) -> tuple[float, ...]:
        """Values of a key of the mooring that the mission's section `optimise` lists; none where it lists none."""
        name = f"{self._moor.name}.{key}"
        sections = [section for section in self.bound.mission.optimise.choose if name in section.all_keys]
        values = []
        for value in (value for section in sections for value in section.choices):
            with suppress(QuantityError):  # `sized` is in no stock; `optimise` tells of what is wrong
                values.append(parse_number_with_unit(value, unit))
        return tuple(values)

    @property
    def designs(self) -> Sequence[str]:
        """Designs in words."""
        return [plan.name for plan in self._plans]

    def posterior(self, bound: DataKind, fit: CauseFit) -> Posterior:
        """Return what a fit of the dives says of its causes and of the mission's own effects."""
        model, state = cast("DescentKind", bound).model, fit.state
        places = model.searched(fit.causes)
        mean = model.prior(fit.causes).centre.copy()
        mean[places] = (state.linear.centre + state.marginal.mean)[places]
        return Posterior(places, mean, state.marginal.covariance[np.ix_(places, places)])

    def predictions(self, design: int, believed: Sequence[Believed]) -> list[Prediction]:
        """Depths of a design's dives as each set of causes predicts them [m]."""
        dives = [
            replace(
                self._logs[0],
                name=f"dive {number + 1}",
                wet_weight=dive.wet_weight,
                line_length=dive.line_length,
                site_depth=dive.site_depth,
            )
            for number, dive in enumerate(self._plans[design].dives)
        ]
        logs = stretched_dives(self.bound.model.forward.coarse, dives)
        return [planned(logs, belief) for belief in believed]

    def predicted(self, logs: tuple[DiveLog, ...], believed: Sequence[Believed]) -> list[Prediction]:
        """Return the depths of dives that were made as each set of causes predicts them [m].

        All sets have data bound to the mission under one explanation.
        """
        return made(logs, believed)

    def cost(self, design: int, seed: int) -> Cost | None:
        """Return what a design takes: the cost of one of its dives, so many times."""
        plan = self._plans[design]
        one = plan.dives[0]
        if one not in self._costs:
            self._costs[one] = cost_of(self._mission(_Dives("one dive", (one,))), seed)
        cost, count = self._costs[one], len(plan.dives)
        if cost is None:
            return None
        return Cost(count * cost.minutes, None if cost.energy_wh is None else count * cost.energy_wh)

    @cached_property
    def _costs(self) -> dict[DiveConditions, Cost | None]:
        return {}

    def trial(self, design: int) -> Mapping[str, object]:
        """Return the mission that makes a design's dives, one mooring each, without a hold."""
        return self._mission(self._plans[design])

    def _mission(self, plan: _Dives) -> Mapping[str, object]:
        raw = copy.deepcopy(dict(self.bound.mission.raw))
        written = raw["phases"]
        entries = written if isinstance(written, list) else []
        mooring = next(entry["moor"] for entry in entries if isinstance(entry, dict) and "moor" in entry)
        phases = [
            {
                "moor": {
                    **mooring,
                    "name": f"dive-{index + 1}",
                    "anchor_wet_weight": f"{dive.wet_weight:.4g} N",
                    "line_length": f"{dive.line_length:.4g} m",
                    "hold": "0 s",
                }
            }
            for index, dive in enumerate(plan.dives)
        ]
        kept = {key: value for key, value in raw.items() if key not in ("requirements", "sweep", "correlations")}
        site = _deepened(kept.get("site"), plan.dives[0].site_depth)
        return kept | {"name": f"Trial: {plan.name}", "site": site, "phases": phases}

    def alternatives(self) -> Alternatives:
        """Return the anchors in stock, or else wet weights about that of the mission."""
        stock = self._in_stock("anchor_wet_weight", "N")
        if len(stock) > 1:
            return Alternatives("anchor_wet_weight_n", np.unique(stock), with_anchor)
        weight = self._moor.anchor_wet_weight
        usual = worst_case_anchor(self.bound.mission) if weight == "sized" else mean_of(weight)
        return Alternatives("anchor_wet_weight_n", usual * FACTORS, with_anchor)


def _deepened(site: object, depth: float) -> dict[str, object]:
    """The site at another depth, where its lowest layer of current goes on to the bottom."""
    section = dict(site) if isinstance(site, dict) else {}
    layers = section.get("current")
    if isinstance(layers, list) and layers and isinstance(layers[-1], dict):
        section["current"] = [*layers[:-1], {**layers[-1], "down_to": f"{depth:.4g} m"}]
    return section | {"depth": f"{depth:.4g} m"}


def _counted(count: int) -> str:
    return {2: "two dives", 4: "four dives"}.get(count, f"{count} dives")
