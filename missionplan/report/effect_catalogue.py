"""The catalogue of effects as text for a terminal: what each is, and a fragment for a mission file."""

import math
import textwrap

from missionplan.effects import CATALOGUE, FAILED_PLUGINS, ORIGINS, EffectInfo, Parameter, exclusive_groups

WIDTH = 80
_INDENT = "  "
_NAME = 20
"""Width of the list's first column."""
_HEAD = "usual size"


def catalogue_text() -> str:
    """List the effects phase by phase, a line each: ID, what it is as far as it fits, usual sizes; failed plug-ins."""
    blocks = []
    for phase in dict.fromkeys(info.phase for info in CATALOGUE.values()):
        title = f"Effects on a {phase}" if phase != "tank" else "Effects seen in a tank alone"
        lines = [_line(info) for info in CATALOGUE.values() if info.phase == phase]
        blocks.append("\n".join([title.ljust(WIDTH - len(_HEAD)) + _HEAD, *lines]) + "\n")
    blocks += [_wrapped(f"The plug-in {name} is left out: {reason}", "") for name, reason in FAILED_PLUGINS.items()]
    blocks.append("missionplan effects ID: all about one of them, with a fragment to paste.")
    return "\n".join(blocks)


def _line(info: EffectInfo) -> str:
    name, size = f"{info.id:<{_NAME}} ", _size(info)
    what = textwrap.shorten(info.what, WIDTH - len(name) - len(size) - 2, placeholder=" …")
    return f"{name}{what}".ljust(WIDTH - len(size)) + size


def _size(info: EffectInfo) -> str:
    """Write the usual size of the first parameter that has one, angles in degrees."""
    for parameter in info.parameters.values():
        size = parameter.median if parameter.is_shape else parameter.scale
        if size:
            sign = "±" if not parameter.is_shape and parameter.low < 0.0 else ""
            angle = f"{sign}{math.degrees(size):.0f}°"
            return angle if parameter.unit == "rad" else f"{sign}{size:g} {parameter.unit}".rstrip()
    return ""


def fragment(info: EffectInfo) -> str:
    """Write an entry of ``effects:`` with the usual size of each parameter."""
    lines = [f"- {info.id}:"]
    for name, parameter in info.parameters.items():
        lines.append(f"    {name}: {_usual(parameter)}  # {parameter.doc}")
    return "effects:\n" + "\n".join(f"  {line}" for line in lines)


def effect_text(info: EffectInfo) -> str:
    """Describe one effect, with a fragment to paste into a mission file."""
    tier = {"statistical": " (a statistical description)", "neutral": " (a response, no cause)"}.get(info.tier, "")
    lines = [f"{info.id}{tier}", _wrapped(info.what)]
    lines += [_wrapped(f"{name}: {_described(parameter)}") for name, parameter in info.parameters.items()]
    lines.append(_wrapped(f"Usual sizes: {info.sizes}"))
    if info.confused_with:
        lines.append(_wrapped(f"Confused with: {', '.join(info.confused_with)}."))
    if info.distinguished_by:
        lines.append(_wrapped(f"Distinguished by: {info.distinguished_by}"))
    for group in exclusive_groups("transit"):
        if info.id in group:
            lines.append(_wrapped(f"Never claimed together with: {', '.join(sorted(group - {info.id}))}."))
    if not info.changes_plan:
        lines.append(_wrapped("Acts on readings alone: it changes no plan."))
    lines += [_wrapped(f"From: {ORIGINS[info.id]}."), "", f"{_INDENT}In a mission file:", ""]
    return "\n".join([*lines, textwrap.indent(fragment(info), 2 * _INDENT)])


def _described(parameter: Parameter) -> str:
    unit = f" [{parameter.unit}]" if parameter.unit else ""
    if parameter.reciprocal_is_uniform:
        return f"{parameter.doc}{unit}; median {parameter.median:g}, its reciprocal is uniform up to twice that"
    if parameter.is_shape:
        return f"{parameter.doc}{unit}; median {parameter.median:g}, 68 % within a factor of {parameter.factor:g}"
    return f"{parameter.doc}{unit}" + (f"; usually within ±{parameter.scale:g}" if parameter.scale else "")


def _usual(parameter: Parameter) -> str:
    value = parameter.median if parameter.is_shape else parameter.scale
    if parameter.high <= 0.0:
        value = -value
    if parameter.low > -1.0 and parameter.low > value:
        value = parameter.low
    return f"{value:g} {parameter.unit}".rstrip()


def _wrapped(text: str, indent: str = _INDENT) -> str:
    return textwrap.fill(text, WIDTH, initial_indent=indent, subsequent_indent=indent + _INDENT)
