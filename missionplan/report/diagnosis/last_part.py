"""The extended mission's score on the part of a record that was kept away from its diagnosis."""

from missionplan.report.page import PageSection
from missionplan.report.scoring.page import dataset_sections, told
from missionplan.results.learned.diagnosis import Diagnosis


def last_part_words(diagnosis: Diagnosis) -> str:
    """Say how well the extended mission predicts what was held out; empty without such a part."""
    last = diagnosis.last_part
    if last is None:
        return ""
    chance = "" if last.is_within_chance else " Chance does not allow such coverages."
    many = "legs" if last.kind == "transit" else "dives"
    return f" Kept away from all this, the last {last.groups} {many}: the extended mission {told(last)}{chance}"


def last_part_sections(diagnosis: Diagnosis) -> list[PageSection]:
    """Show the scores on what was held out beside yardsticks."""
    if diagnosis.last_part is None:
        return []
    return dataset_sections(diagnosis.last_part, "The last part, held out")
