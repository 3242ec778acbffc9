"""What alternatives reach of what is required, and in what their missions differ."""

from collections.abc import Iterator

from missionplan.report.compared.run_numbers import limit_in_words, requirements_of
from missionplan.report.numbers import number, percent, share
from missionplan.report.page import PageSection, Table
from missionplan.report.wording import in_words
from missionplan.results.choosing.alternatives import Alternatives
from missionplan.results.plain_data import mapping
from missionplan.results.simulation import RequirementOutcome

_MOST_DIFFERING = 60


def requirements_section(found: Alternatives) -> Iterator[PageSection]:
    """Show what each alternative reaches of each requirement."""
    told = percent if len(found.alternatives) == 2 else share
    reached = [
        {_asked(item, found.provenance.data.get(each.name)): told(item.probability) for item in each.requirements}
        for each in found.alternatives
    ]
    asked = list(dict.fromkeys(key for each in reached for key in each))
    if asked:
        rows = [[*key, *(each.get(key, "–") for each in reached)] for key in asked]
        columns = ["requirement", "required", *(each.name for each in found.alternatives)]
        yield PageSection("What each reaches of what is required", [Table(columns, rows)])


def _asked(item: RequirementOutcome, mission: object) -> tuple[str, str]:
    """Write what is required and how surely; both may differ from mission to mission."""
    written = requirements_of(mapping(mission))
    alike = [each for each in written if each.get("quantity") == item.quantity and (item.bound or "quantity") in each]
    if len(alike) == 1:
        limit = limit_in_words(alike[0])
    else:
        limit = f"{item.bound.replace('_', ' ')} {number(item.limit or 0.0)}" if item.bound else ""
    return f"{in_words(item.quantity)} {limit}".strip(), f"{number(100.0 * item.required)}\u00a0%"


def differing_section(found: Alternatives) -> Iterator[PageSection]:
    """List the values in which the missions differ."""
    if not found.differing:
        return
    rows = [[each.path, *(value or "–" for value in each.values)] for each in found.differing[:_MOST_DIFFERING]]
    count = len(found.differing)
    more = f"The first {_MOST_DIFFERING} of {count}." if count > _MOST_DIFFERING else ""
    heading = "1 value of the missions differs" if count == 1 else f"{count} values of the missions differ"
    names = [each.name for each in found.alternatives]
    yield PageSection(heading, [Table(["key", *names], rows, more, text_columns=len(names) + 1)])
