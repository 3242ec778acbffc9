"""A mission's file written back with its comments where its data have changed."""

import copy
import os.path
import re
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import yaml

from missionplan.mission.documents import Document
from missionplan.montecarlo.posterior import PosteriorFile

_WIDTH = 110
"""Longest line of a value that is written in braces."""


def edited(text: str, data: object) -> str:
    """Return a file's text with other data.

    Parameters
    ----------
    text : str
        Valid YAML.
    data : object
        What the text is to hold. Values that it holds already stay as they are written.

    Returns
    -------
    str
        Where the text cannot be edited (anchors, say), the data alone, without comments.
    """
    editor, node = _Editor(text), _composed(text)
    try:
        editor.compare(node, data, None)
        result = editor.applied()
        if yaml.safe_load(result) == data:
            return result
    except (yaml.YAMLError, _CannotEditError):
        pass
    return dumped(data)


def dumped(data: object) -> str:
    """Write data as YAML, keys in their order."""
    if isinstance(data, Mapping) and isinstance(data.get(_POSTERIOR), PosteriorFile):
        data = {**data, _POSTERIOR: dict(data[_POSTERIOR])}
    return yaml.safe_dump(data, sort_keys=False, allow_unicode=True, width=120)


def _composed(text: str) -> yaml.Node:
    node = yaml.compose(text, Loader=yaml.SafeLoader)
    if node is None:
        raise ValueError("the text holds nothing")
    return node


class _CannotEditError(ValueError):
    """A text that edits in place would spoil."""


class _Editor:
    """Collects the edits of a text: each a start, an end and what stands between them afterwards."""

    def __init__(self, text: str) -> None:
        self.text = text
        self._loader = yaml.SafeLoader("")
        self._edits: dict[tuple[int, int], str] = {}

    def compare(self, node: yaml.Node, data: object, key: yaml.Node | None, *, in_flow: bool = False) -> None:
        """Note the edits that give a node other data; `key` is that of its mapping, where it has one."""
        flow = in_flow or bool(getattr(node, "flow_style", False))
        if isinstance(node, yaml.MappingNode) and isinstance(data, dict) and data and node.value:
            if flow and {inner.value for inner, _ in node.value} - set(data):
                self._replace(node, data, key, in_flow=in_flow)
            else:
                self._compare_keys(node, data, in_flow=flow)
        elif isinstance(node, yaml.SequenceNode) and isinstance(data, list) and len(data) == len(node.value):
            for inner, item in zip(node.value, data, strict=True):
                self.compare(inner, item, None, in_flow=flow)
        elif not self._holds(node, data):
            self._replace(node, data, key, in_flow=in_flow)

    def _compare_keys(self, node: yaml.MappingNode, data: Mapping[str, object], *, in_flow: bool) -> None:
        """Note the edits of each key of a mapping, of those that go and of those that come."""
        for key, value in node.value:
            if key.value in data:
                self.compare(value, data[key.value], key, in_flow=in_flow)
                continue
            start = self.text.rfind("\n", 0, key.start_mark.index) + 1
            if self.text[start : key.start_mark.index].strip():  # it shares its line with a list's dash
                raise _CannotEditError
            end = self._line_end(self._end(value))
            self._note(*((start - 1, end) if start else (0, min(end + 1, len(self.text)))), "")
        names = {inner.value for inner, _ in node.value}
        self._append(node, [(name, value) for name, value in data.items() if name not in names], in_flow=in_flow)

    def applied(self) -> str:
        """Return the text with the edits made."""
        text, last = self.text, len(self.text)
        for (start, end), new in sorted(self._edits.items(), reverse=True):
            if end > last:
                raise _CannotEditError
            text, last = text[:start] + new + text[end:], start
        return text

    def _holds(self, node: yaml.Node, data: object) -> bool:
        is_scalar = isinstance(node, yaml.ScalarNode)
        value = self._loader.construct_object(node) if is_scalar else self._loader.construct_document(node)
        return type(value) is type(data) and value == data

    def _note(self, start: int, end: int, new: str) -> None:
        if self._edits.setdefault((start, end), new) != new:
            raise _CannotEditError

    def _replace(self, node: yaml.Node, data: object, key: yaml.Node | None, *, in_flow: bool) -> None:
        """Write a value anew; a block after its key begins on the key's line."""
        start, end = node.start_mark.index, self._end(node)
        indent = key.start_mark.column if key is not None else node.start_mark.column
        if key is not None and self._is_block(node):
            start = self.text.index(":", key.end_mark.index) + 1
            self._note(start, end, _written(data, indent, in_flow=in_flow, lead=" "))
        else:
            before = self.text[:start]
            kept = len(before) - len(before.rstrip(" ")) if before.endswith(" ") and key is not None else 0
            new = _written(data, indent, in_flow=in_flow, lead="")
            self._note(start - kept if new.startswith("\n") else start, end, new)

    def _append(self, node: yaml.MappingNode, added: list[tuple[object, object]], *, in_flow: bool) -> None:
        """Add keys at the end of a mapping."""
        if not added:
            return
        if in_flow:
            place = self._end(node) - 1
            new = "".join(f", {name}: {_flow(value)}" for name, value in added)
            self._note(place, place, new)
            return
        column = node.value[0][0].start_mark.column
        place = self._line_end(self._end(node))
        lines = (f"\n{' ' * column}{name}:{_written(value, column, in_flow=False, lead=' ')}" for name, value in added)
        self._note(place, place, "".join(lines))

    def _end(self, node: yaml.Node) -> int:
        """Where the content of a node ends: what the parser takes for a block's end lies behind its comments."""
        if self._is_block(node) and node.value:
            last = node.value[-1]
            return self._end(last[1] if isinstance(last, tuple) else last)
        end = int(node.end_mark.index)
        return end if not isinstance(node, yaml.ScalarNode) else len(self.text[:end].rstrip())

    @staticmethod
    def _is_block(node: yaml.Node) -> bool:
        return isinstance(node, yaml.CollectionNode) and not node.flow_style

    def _line_end(self, index: int) -> int:
        end = self.text.find("\n", index)
        return len(self.text) if end < 0 else end


def _written(value: object, indent: int, *, in_flow: bool, lead: str) -> str:
    """Write a value after its key: in braces where it fits a line, else as a block below."""
    flow = _flow(value)
    if in_flow or not isinstance(value, dict | list) or indent + len(flow) <= _WIDTH:
        return lead + flow
    block = yaml.safe_dump(value, sort_keys=False, allow_unicode=True, width=_WIDTH, default_flow_style=None)
    return "\n" + textwrap.indent(block.rstrip("\n"), " " * (indent + 2))


def _flow(value: object) -> str:
    """Write a value so that it may stand inside braces."""
    text = yaml.safe_dump([value], default_flow_style=True, sort_keys=False, allow_unicode=True, width=1_000_000)
    return re.sub(r"^\[|\]\n$", "", text)


_VEHICLE, _POSTERIOR = "vehicle", "posterior"


@dataclass(frozen=True)
class MissionText:
    """What a mission was read from."""

    text: str
    """Of the mission file."""
    written: Mapping[str, object]
    """Its data as written: a vehicle by the name of its file."""
    folder: Path
    """Of the file."""
    current_file: str
    """The file of the current as it was resolved; empty where there is none."""
    vehicle: Mapping[str, object] | None
    """Data of the vehicle's file, where the mission names one."""
    vehicle_text: str
    """Its text."""

    @classmethod
    def of(cls, document: Document, written: Mapping[str, object], folder: Path) -> "MissionText | None":
        """Take the texts of a document with its files included; None where it was read from no file."""
        if () not in document.texts:
            return None
        named = (_VEHICLE,) in document.texts
        vehicle = copy.deepcopy(document.data[_VEHICLE]) if named else None
        text = document.texts.get((_VEHICLE,), "")
        return cls(document.texts[()], written, folder, _current_file(document.data), vehicle, text)

    def with_data(self, data: Mapping[str, object], folder: Path | None = None) -> str:
        """Return the text with other data, for a file in `folder`; default: that of the file it was read from."""
        new = copy.deepcopy(dict(data))
        stays = folder is None or folder.resolve() == self.folder.resolve()
        self._name_current(new, folder or self.folder, stays=stays)
        part = new.get(_POSTERIOR)
        if isinstance(part, PosteriorFile):
            kept = self.keeps_draws(part, folder or self.folder)
            new[_POSTERIOR] = self.written[_POSTERIOR] if kept else dict(part)
        if self.vehicle is None or not isinstance(new.get(_VEHICLE), Mapping):
            return edited(self.text, new)
        name, vehicle = self.written[_VEHICLE], new[_VEHICLE]
        if stays and vehicle == self.vehicle:
            return edited(self.text, {**new, _VEHICLE: name})
        part = edited(self.vehicle_text, vehicle)  # stands in the place of the name of its file
        text = edited(self.text, {**new, _VEHICLE: name})
        for key_node, value in _composed(text).value:
            if key_node.value == _VEHICLE:
                start = text.index(":", key_node.end_mark.index) + 1
                rest, newline, below = text[value.end_mark.index :].partition("\n")
                return text[:start] + rest + "\n" + textwrap.indent(part.strip("\n"), "  ") + newline + below
        return text

    def keeps_draws(self, posterior: PosteriorFile | None, folder: Path) -> bool:
        """Whether a mission written into a folder finds its draws where the file that it was read from has them."""
        before = self.written.get(_POSTERIOR) if folder.resolve() == self.folder.resolve() else None
        return posterior is not None and isinstance(before, Mapping) and before.get("sha256") == posterior["sha256"]

    def _name_current(self, data: dict[str, object], folder: Path, *, stays: bool) -> None:
        """Name the file of the current as before, else relative to the folder where it lies in it."""
        file = _current_file(data)
        if not file:
            return
        site = data["site"]
        current = site["current"] if isinstance(site, dict) else {}
        if stays and file == self.current_file:
            current["file"] = _current_file(self.written)
        elif Path(file).resolve().is_relative_to(folder.resolve()):
            current["file"] = os.path.relpath(Path(file).resolve(), folder.resolve())


def _current_file(data: Mapping[str, object]) -> str:
    site = data.get("site")
    current = site.get("current") if isinstance(site, Mapping) else None
    file = current.get("file") if isinstance(current, Mapping) else None
    return file if isinstance(file, str) else ""
