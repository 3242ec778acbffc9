"""What the claimed causes leave of the data: a smooth discrepancy along some axis, or none."""

from missionplan.report.diagnosis.figures import discrepancy_figure
from missionplan.report.page import Block, PageSection, Table
from missionplan.results.learned.diagnosis import Diagnosis
from missionplan.results.learned.evidence import Discrepancy, ResidualTest

_TESTS_SHOWN = 5


def discrepancy_section(diagnosis: Diagnosis) -> PageSection:
    """Show what is left, and the tests for it."""
    found = diagnosis.discrepancy
    if not found.by_axis:
        none = "A handful of numbers has no structure that could be tested."
        return PageSection("Too few data to look for what is left", [none])
    blocks: list[Block] = [discrepancy_figure(found, found.shape)] if found.shape is not None else []
    blocks.append(
        f"A smooth discrepancy along any axis: ln BF = {found.log_bayes_factor:.1f} (above 3 it counts). It is tested "
        "for, and is no part of the extended mission. With the mission's model alone: "
        f"{diagnosis.base_discrepancy.log_bayes_factor:.1f}."
    )
    rows = [[axis, f"{value:.1f}"] for axis, value in found.by_axis]
    blocks.append(Table(["What it could look like", "ln BF of a smooth discrepancy"], rows))
    if found.tests:
        blocks.append(_tests(found.tests))
    heading = "Nothing structured is left" if found.axis is None else f"What is left {resemblance(found)}"
    return PageSection(heading, blocks)


def resemblance(found: Discrepancy) -> str:
    """Write what a discrepancy looks like, or along what it is structured: the end of a sentence."""
    if found.resembles is None:
        return f"is structured along {found.axis}"
    return f"looks like {found.resembles}"


def _tests(tests: tuple[ResidualTest, ...]) -> Table:
    least = sorted(tests, key=lambda test: test.p_value)[:_TESTS_SHOWN]
    rows = [[test.name, f"{test.p_value:.2g}"] for test in least]
    chance = 1.0 / len(tests)
    caption = f"The smallest p-values of {len(tests)} tests; by chance alone the least would be about {chance:.2g}."
    return Table(["Test of the errors left", "p-value"], rows, caption)
