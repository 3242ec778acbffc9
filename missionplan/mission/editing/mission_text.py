"""The text of a mission file and of the vehicle file that it names, to be written back with changed data."""

import copy
import os.path
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from missionplan.mission.editing.yaml_text import edited, with_inlined
from missionplan.mission.reading.documents import Document

_VEHICLE = "vehicle"


@dataclass(frozen=True)
class MissionText:
    """What a mission was read from.

    Attributes
    ----------
    text : str
        Of the mission file.
    written : mapping
        Its data as written: a vehicle by the name of its file.
    folder : Path
        Of the file.
    current_file : str
        The file of the current as it was resolved; empty where there is none.
    vehicle : mapping or None
        Data of the vehicle's file, where the mission names one.
    vehicle_text : str
        Its text.
    """

    text: str
    written: Mapping[str, object]
    folder: Path
    current_file: str
    vehicle: Mapping[str, object] | None
    vehicle_text: str

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
        if self.vehicle is None or not isinstance(new.get(_VEHICLE), Mapping):
            return edited(self.text, new)
        name, vehicle = self.written[_VEHICLE], new[_VEHICLE]
        if stays and vehicle == self.vehicle:
            return edited(self.text, {**new, _VEHICLE: name})
        own = edited(self.vehicle_text, vehicle)
        return with_inlined(edited(self.text, {**new, _VEHICLE: name}), _VEHICLE, own)

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
