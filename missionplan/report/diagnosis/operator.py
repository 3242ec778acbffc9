"""What was found, as the operator is told it: size, sign, what to do about it, and what that gains."""

import math
from collections.abc import Mapping
from dataclasses import replace

from missionplan.effects import CATALOGUE
from missionplan.effects.finding import Finding
from missionplan.report.diagnosis.data_kinds.kinds import REPORTS
from missionplan.report.diagnosis.evidence import claimed_parameters, sized
from missionplan.report.wording import capitalised
from missionplan.results.learned.diagnosis import Diagnosis
from missionplan.results.learned.evidence import ParameterEstimate

_PERCENT = 100.0


def finding_in_words(diagnosis: Diagnosis) -> str:
    """Write what was found and what to do: ``The compass reads 2.9° ± 0.3° low: swing it, …``; empty without causes.

    What the catalogue says nothing of, or too large to be its cause, is left to the verdict.
    """
    found = claimed_parameters(diagnosis)
    told = [_clause(cause, found) for cause in diagnosis.causes]
    if not told or not all(told):
        return ""
    hedge = "It looks as if " if diagnosis.verdict in ("ambiguous", "partly-explained") else ""
    return capitalised(f"{hedge}{'; and '.join(told)}{_gained(diagnosis)}.")


def _clause(cause: str, found: tuple[ParameterEstimate, ...]) -> str:
    info = CATALOGUE[cause]
    finding = info.finding
    if finding is None:
        return ""
    mine = {each.name: each for each in found if each.effect == cause}
    limit = info.likeness
    if limit is not None and limit.parameter in mine and abs(mine[limit.parameter].value) > limit.size:
        return ""
    words = _sized_clause(finding, mine)
    return f"{words}: {finding.remedy}" if words and finding.remedy else words


def _sized_clause(finding: Finding, mine: Mapping[str, ParameterEstimate]) -> str:
    if not finding.parameter:
        return finding.positive
    estimate = mine.get(finding.parameter)
    if estimate is None:
        return ""
    if finding.toward is not None:
        return _vector_clause(finding, mine)
    clause = finding.negative if estimate.value < 0.0 and finding.negative else finding.positive
    return clause.format(size=_size(estimate, finding))


def _vector_clause(finding: Finding, mine: Mapping[str, ParameterEstimate]) -> str:
    """Write size and direction of a vector by its components; its error is that along it."""
    parts = [mine.get(name) for name in finding.toward or ()]
    east, north = parts
    if east is None or north is None:
        return ""
    length = math.hypot(east.value, north.value)
    sd = math.hypot(east.value * east.sd, north.value * north.sd) / max(length, 1e-12)
    size = sized(_changed(east, length, sd))
    direction = f"{math.degrees(math.atan2(east.value, north.value)) % 360.0:.0f}°"
    return finding.positive.format(size=size, direction=direction)


def _size(estimate: ParameterEstimate, finding: Finding) -> str:
    if finding.in_percent:
        share = _changed(estimate, _PERCENT * abs(estimate.value), _PERCENT * estimate.sd)
        return sized(replace(share, unit="%"))
    return sized(_changed(estimate, abs(estimate.value), estimate.sd))


def _changed(estimate: ParameterEstimate, value: float, sd: float) -> ParameterEstimate:
    return replace(estimate, value=value, sd=sd)


def _gained(diagnosis: Diagnosis) -> str:
    """Write how much better what was held out is predicted."""
    best = diagnosis.best
    if best is None or best.held_out is None or best.held_out.rmse_extended >= best.held_out.rmse_base:
        return ""
    return REPORTS[diagnosis.kind].gained(diagnosis, best.held_out.rmse_base, best.held_out.rmse_extended)
