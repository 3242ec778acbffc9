"""The plan's states as a drawing (SVG): one under the other, phase by phase, with the guards that lead on.

What leads to the next state stands under the state, what leads elsewhere at its left, and what leads to `abort` at its
right; a guard that holds in all states of a phase leaves from the phase's frame. Each text has a row, or a column, of
its own: none lies over another, whatever the mission's names and numbers.
"""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, field
from xml.etree import ElementTree

from missionplan.exporters import Element, add, document, one_interval
from missionplan.results.plan import Plan
from missionplan.results.plan_states import ACTIONS, State, Transition, states_of

TITLE = "a drawing of the plan's states (SVG)"
NEEDS_ORIGIN = False
lost = one_interval

_INK, _GRID, _ABORT, _PHASE = "#222222", "#dddddd", "#D55E00", "#0072B2"
_LEFT, _BOX, _RIGHT, _WIDTH = 160.0, 330.0, 240.0, 800.0
"""Widths of what stands at the left of the states, of a state, of what stands at its right, and of all [px]."""
_BOX_RIGHT, _FRAME_RIGHT, _BAR = _LEFT + _BOX, _LEFT + _BOX + 10.0, _LEFT + _BOX + _RIGHT
_LINE, _LETTER = 15.0, 7.0
"""Height of a line, and the most that a letter of it is wide on average [px]."""
_STEM = _LEFT + 20.0
"""Where the arrows to the next state are."""
_ABORTED = "abort"


@dataclass
class _Sheet:
    """What is drawn so far, and down to where [px]."""

    root: Element
    y: float = 10.0
    tops: dict[str, float] = field(default_factory=dict)
    middles: dict[str, float] = field(default_factory=dict)

    def text(self, x: float, y: float, words: str, **style: str) -> None:
        add(self.root, "text", words, x=f"{x:.1f}", y=f"{y:.1f}", **{"fill": _INK, **style})

    def box(self, x: float, y: float, size: tuple[float, float], **style: str) -> None:
        attributes = {"width": f"{size[0]:.1f}", "height": f"{size[1]:.1f}", "rx": "6", "fill": "none", "stroke": _INK}
        add(self.root, "rect", x=f"{x:.1f}", y=f"{y:.1f}", **{**attributes, **style})

    def arrow(self, *points: tuple[float, float], colour: str = _INK) -> None:
        """Draw a line through points, with a head at the last."""
        way = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        add(self.root, "polyline", points=way, fill="none", stroke=colour)
        (x0, y0), (x, y) = points[-2:]
        length = abs(x - x0) + abs(y - y0)  # all lines are level or upright
        dx, dy = 6.0 * (x - x0) / length, 6.0 * (y - y0) / length
        head = ((x, y), (x - dx - dy / 2.0, y - dy - dx / 2.0), (x - dx + dy / 2.0, y - dy + dx / 2.0))
        add(self.root, "polygon", points=" ".join(f"{a:.1f},{b:.1f}" for a, b in head), fill=colour)


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write one file."""
    return {f"{stem}.svg": document(drawing(plan), f"Plan of the mission {plan.mission}, SHA-256 {plan.digest}")}


def _asked(transition: Transition) -> str:
    """Write what a transition asks."""
    return " and ".join(guard.words for guard in transition.guards)


def drawing(plan: Plan) -> Element:
    """Draw the states of a plan."""
    states = states_of(plan)
    root = ElementTree.Element("svg", xmlns="http://www.w3.org/2000/svg")
    root.set("font-family", "system-ui, sans-serif")
    root.set("font-size", "12")
    sheet = _Sheet(root)
    add(root, "circle", cx=f"{_STEM:.1f}", cy="10", r="5", fill=_INK)
    drawn = [state for state in states if state.name != _ABORTED]
    groups: dict[str, list[State]] = {}
    for state in drawn:
        groups.setdefault(state.name.rpartition("-")[0], []).append(state)
    following = dict(zip((state.name for state in drawn), (state.name for state in drawn[1:]), strict=False))
    entry = 15.0
    for group in groups.values():
        entry = _group(sheet, group, following, entry)
    _elsewhere(sheet, drawn, following)
    sheet.box(_BAR, 5.0, (50.0, sheet.y - 5.0), stroke=_ABORT)
    middle = sheet.y / 2.0
    turned = {"transform": f"rotate(90 {_BAR + 21.0:.1f} {middle:.1f})", "text-anchor": "middle", "font-weight": "bold"}
    sheet.text(_BAR + 21.0, middle, f"{_ABORTED}: {ACTIONS['abort']}", **turned)
    root.set("viewBox", f"0 0 {_WIDTH:.0f} {sheet.y + 10.0:.0f}")
    root.set("width", f"{_WIDTH:.0f}")
    root.set("height", f"{sheet.y + 10.0:.0f}")
    return root


def _group(sheet: _Sheet, group: Sequence[State], following: dict[str, str], entry: float) -> float:
    """Draw the states of a phase in a frame; `entry` is where the arrow into it begins. Return where the next does."""
    common = [edge for edge in group[0].transitions if all(edge in state.transitions for state in group)]
    framed, top = bool(group[0].phase), sheet.y + 12.0
    sheet.y = top
    if framed:
        name, most = f"{group[0].name.rpartition('-')[0]} {group[0].phase}", int((_BOX - 60.0) / _LETTER)
        name = name if len(name) <= most else f"{name[: most - 1]}…"
        sheet.text(_STEM + 20.0, top + 18.0, name, fill=_PHASE, **{"font-weight": "bold"})
        for edge in common:
            _abort(sheet, _FRAME_RIGHT, sheet.y + 20.0, _asked(edge))
            sheet.y += _LINE + 3.0
        sheet.y = max(sheet.y, top + 18.0)
    sheet.y += 12.0
    for state in group:
        sheet.arrow((_STEM, entry), (_STEM, sheet.y))
        entry = _state(sheet, state, [edge for edge in state.transitions if edge not in common], following)
    if framed:
        sheet.box(5.0, top, (_FRAME_RIGHT - 5.0, entry - top + 5.0), stroke=_GRID)
    return entry


def _state(sheet: _Sheet, state: State, transitions: Sequence[Transition], following: dict[str, str]) -> float:
    """Draw a state, what leads on from it and what leads to the end; return where its arrow down begins."""
    does = textwrap.wrap(ACTIONS[state.kind], int((_BOX - 16.0) / _LETTER))
    aborts = [edge for edge in transitions if edge.to == _ABORTED]
    height = max(12.0 + _LINE * (1 + len(does)), (_LINE + 3.0) * len(aborts))
    top = sheet.y
    sheet.tops[state.name], sheet.middles[state.name] = top, top + height / 2.0
    sheet.box(_LEFT, top, (_BOX, height))
    sheet.text(_LEFT + 8.0, top + 17.0, state.kind, **{"font-weight": "bold"})
    for number, line in enumerate(does, start=1):
        sheet.text(_LEFT + 8.0, top + 17.0 + _LINE * number, line)
    for number, edge in enumerate(aborts):
        _abort(
            sheet,
            _BOX_RIGHT,
            top + height / 2.0 + (_LINE + 3.0) * (number - (len(aborts) - 1) / 2.0),
            _asked(edge),
        )
    sheet.y += height
    on = [_asked(edge) for edge in transitions if edge.to == following.get(state.name)]
    for words in (*on[:1], *(f"or {words}" for words in on[1:])):
        for line in textwrap.wrap(words, int((_BOX - 40.0) / _LETTER), subsequent_indent="   "):
            sheet.y += _LINE
            indent = 10.0 if line == line.lstrip() else 24.0
            sheet.text(_STEM + indent, sheet.y + 2.0, line.lstrip())
    sheet.y += 14.0
    return top + height


def _abort(sheet: _Sheet, begins: float, y: float, words: str) -> None:
    """Draw an arrow to the end, its words on it."""
    sheet.text(begins + 16.0, y - 4.0, words, fill=_ABORT)
    sheet.arrow((begins, y), (_BAR, y), colour=_ABORT)


def _elsewhere(sheet: _Sheet, states: Sequence[State], following: dict[str, str]) -> None:
    """Draw what leads neither to the next state nor to the end, at the left."""
    for state in states:
        others = [edge for edge in state.transitions if edge.to not in (following.get(state.name), _ABORTED)]
        for number, edge in enumerate(others):
            lane, y = _LEFT - 14.0 - 8.0 * number, sheet.middles[state.name] + 8.0 * number
            sheet.arrow((_LEFT, y), (lane, y), (lane, sheet.middles[edge.to]), (_LEFT, sheet.middles[edge.to]))
            lines = textwrap.wrap(_asked(edge), int((lane - 15.0) / _LETTER))
            for row, line in enumerate(lines):
                at = y - _LINE * (len(lines) - row - 1) + 2.0
                sheet.text(lane - 5.0, at, line, **{"text-anchor": "end"})
