"""A result on one screen of text."""

from missionplan.report.glance.table import laid_out
from missionplan.report.render import terminal_view
from missionplan.report.typesetting import wrapped
from missionplan.results.base import Result

WIDTH = 79
MOST_LINES = 29
_MOST_OF_ANSWER = 10
"""Lines of the answer."""


def text(result: Result) -> str:
    """Write what the result is, its answer, and its main table as far as it fits a screen."""
    shown = terminal_view(result)
    answer = wrapped(shown.sentence, WIDTH).splitlines()
    if len(answer) > _MOST_OF_ANSWER:
        answer = [*answer[: _MOST_OF_ANSWER - 1], f"{answer[_MOST_OF_ANSWER - 1]} ..."]
    head = [heading(result), *answer]
    table = laid_out(shown.columns, shown.rows, WIDTH) if shown.rows else []
    room = MOST_LINES - len(head)
    if len(table) > room:
        table = [*table[: room - 1], f"... {len(table) - room + 1} more lines; to_frame() has all"]
    return "\n".join([*head, *table])


def heading(result: Result) -> str:
    """Name the kind of result, the study, the mission and its trials."""
    provenance = result.provenance
    trials = f", {provenance.trials} trials, seed {provenance.seed}" if provenance.trials else ""
    start, mission = f"<{type(result).__name__}: {provenance.command}", provenance.mission or provenance.file
    room = WIDTH - len(f"{start} of {trials}>")
    name = mission if len(mission) <= room else f"{mission[: room - 3].rstrip()}..."
    return f"{start}{' of ' if name else ''}{name}{trials}>"
