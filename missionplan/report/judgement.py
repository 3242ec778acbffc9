"""Words on a recommendation that was judged: the mission with it, simulated with fresh draws."""

from missionplan.report.numbers import percent
from missionplan.report.simulation.quantities import requirement_in_words
from missionplan.results.simulation import Outcome


def judged_in_words(judged: Outcome | None) -> str:
    """Write which of the mission's requirements are met on fresh draws; nothing for a mission that requires nothing."""
    if judged is None:
        return ""
    missed = [item for item in judged.requirements if not item.met]
    if not missed:
        return f" The mission with it meets all {len(judged.requirements)} requirements on fresh draws."
    words = "; ".join(
        f"{requirement_in_words(judged, item)} in {percent(item.probability)}, "
        f"{100.0 * item.required:g}\u00a0% required"
        for item in missed
    )
    return f" The mission with it misses a requirement on fresh draws: {words}."
