"""Which member of the current's ensemble spoils a plan, in a sentence and a table."""

from collections.abc import Iterator, Sequence

from missionplan.report.numbers import percent, share
from missionplan.report.page import PageSection, Table
from missionplan.results.members import MemberOutcome, members_differ

DIFFER = "Which member of the current's ensemble spoils the {}"


def members_in_words(members: Sequence[MemberOutcome], does: str) -> str:
    """Write in a sentence which member spoils what a plan `does`; empty without an ensemble."""
    if not members:
        return ""
    worst, best = (pick(members, key=lambda each: each.good.value) for pick in (min, max))
    low, high = share(worst.good), share(best.good)
    if members_differ(members):
        return f"It depends on the forecast: it {does} {low} of the time in {worst.name} and {high} in {best.name}."
    ends = f"{low} to {high}" if low != high else f"in {low} of the trials"
    return f"In each member of the current's ensemble it {does} as often, as far as the trials can tell ({ends})."


def members_section(members: Sequence[MemberOutcome], plan: str, good: str, note: str) -> Iterator[PageSection]:
    """Tabulate the members, the worst first; `plan` and `good` are words for the heading and a column."""
    if not members:
        return
    rows = [
        [each.name, f"{100.0 * each.probability:.1f}\u00a0%", percent(each.good)]
        for each in sorted(members, key=lambda each: each.good.value)
    ]
    heading = DIFFER.format(plan) if members_differ(members) else "Members of the current's ensemble"
    yield PageSection(heading, [Table(("member", "probability", good), rows, note)])
