"""In what the tasks of missions differ, in words."""

from collections.abc import Mapping, Sequence

_WORDS = {
    "phases": "in their phases",
    "place": "in the place",
    "depth": "in the depth of the water",
    "requirements": "in what is required",
}
_OF_PHASES = {"from": "where {} begins", "to": "where {} leads", "hold": "how long {} holds"}


def task_in_words(differs: Mapping[str, Sequence[str]]) -> str:
    """Write ``in where ingress leads, in the depth of the water and in what is required``."""
    parts = [_part(part, paths) for part, paths in differs.items()]
    return ", ".join(parts[:-1]) + f" and {parts[-1]}" if len(parts) > 1 else "".join(parts)


def _part(part: str, paths: Sequence[str]) -> str:
    if part in _WORDS:
        return _WORDS[part]
    names = list(dict.fromkeys(path.partition(".")[0] for path in paths))
    plural = {"begins": "begin", "leads": "lead", "holds": "hold"}
    words = _OF_PHASES[part]
    if len(names) > 1:
        verb = words.rpartition(" ")[2]
        words = words.removesuffix(verb) + plural[verb]
    return "in " + words.format(" and ".join(names))
