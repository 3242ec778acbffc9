"""The mission: what a mission file holds, validated and in SI, with distributions kept as distributions."""

import copy
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Generic, Self, TypeVar, cast

from pydantic import PrivateAttr, ValidationError

from missionplan.arrays import Scalars
from missionplan.errors import InputError, LocalProblem, Problem, key_path, shown
from missionplan.mission.changes import changed_data
from missionplan.mission.checks import notices
from missionplan.mission.checks.sections import (
    check_correlations,
    check_phases,
    check_site,
    misspelt_requirements,
    read_requirements,
)
from missionplan.mission.documents import Document, unprintable_texts
from missionplan.mission.includes import REMOTE, include_files, with_contents
from missionplan.mission.learned import at_date, left_behind, still_alike, turned_draws, turned_effects
from missionplan.mission.quantity_paths import SHARED, ValueInForce, changed, joined, name_in_force, values_in_force
from missionplan.mission.schema import V
from missionplan.mission.schema.effect_list import POSTERIOR
from missionplan.mission.sections import Sections
from missionplan.mission.validation_errors import in_order, validation_problems
from missionplan.mission.yaml_text import MissionText, dumped
from missionplan.montecarlo.distributions import Distribution, mean_of
from missionplan.montecarlo.posterior import FILE, Place
from missionplan.store.folder import as_path, exists, matching, write_atomically

_New = TypeVar("_New")


class Mission(Sections[V], Generic[V]):
    """A mission file, validated. All in SI; quantities are floats or distributions; drawn, floats or arrays."""

    _raw: dict[str, object] = PrivateAttr(default_factory=dict)
    _file: str = PrivateAttr(default="")
    _unusual: tuple[str, ...] = PrivateAttr(default=())
    _sources: tuple[Path, ...] = PrivateAttr(default=())
    _text: MissionText | None = PrivateAttr(default=None)

    def __repr__(self) -> str:
        phases = ", ".join(phase.label for phase in self.phases) or "none"
        where = f" of {self.file}" if self.file else ""
        return f"<Mission {self.name!r}{where}: phases {phases}; {len(self.uncertain())} uncertain quantities>"

    @classmethod
    def from_data(cls, data: Mapping[str, object], *, file: str = "") -> "Mission":
        """Validate a mission's data, such as another mission's `raw` with changes, as `load` does a file's.

        Parameters
        ----------
        data : mapping
            What a mission file holds; copied. Paths in it (`vehicle`, `site.current.file`) may point anywhere and are
            relative to the working directory.
        file : str
            How messages name the mission.

        Raises
        ------
        InputError
            With every problem: key path, what was given, what was expected.
        """
        if not isinstance(data, Mapping):
            raise InputError([Problem(f"given {shown(data)}, expected a mapping of sections", key="data")])
        document = Document(copy.deepcopy(dict(data)), {(): (file, None)})
        unprintable = [document.located(problem) for problem in unprintable_texts(document.data)]
        if unprintable:
            raise InputError(unprintable)
        return cls.from_document(document, Path(), allow_outside=True, file=file)

    @classmethod
    def from_document(cls, document: Document, folder: Path, *, allow_outside: bool, file: str) -> "Mission":
        """Validate a document, whose included files are put in their places.

        Parameters
        ----------
        folder : Path
            To which paths in the document are relative.
        allow_outside : bool
            Whether included files may lie outside that folder.
        file : str
            How messages name the mission.

        Raises
        ------
        InputError
            With every problem, where the document has them with file and line.
        """
        if not isinstance(document.data, dict):
            raise InputError([document.problem((), "expected a mapping of sections such as `phases:`")])
        written = copy.deepcopy(document.data)
        problems = include_files(document, folder, allow_outside=allow_outside)
        try:
            mission: Mission = Mission.model_validate(document.data)
        except ValidationError as error:
            misspelt = [document.located(problem) for problem in misspelt_requirements(document.data)]
            raise InputError(in_order([*problems, *validation_problems(error, document, cls), *misspelt])) from None
        mission = mission._from_its_start()
        requirements, wrong = read_requirements(mission.requirements, mission.phases)
        limits = mission._limits()
        undated = "the mission has no start, which the date of these phases needs"
        between = [
            *check_phases(mission.phases, mission.site, mission.vehicle, mission.navigation, mission.sweep),
            *check_site(mission.site, mission.phases),
            *(LocalProblem((*e.path, e.effect, "epoch"), undated) for e in mission.effects if e.epoch is not None),
            *check_correlations(mission.correlations, mission.quantities(), mission.doubts),
        ]
        problems += [document.located(problem) for problem in (*between, *wrong, *limits.problems)]
        if problems:
            raise InputError(in_order(problems))
        mission = mission.model_copy(update={"requirements": requirements})
        mission._raw, mission._file = document.data, file
        mission._text = MissionText.of(document, written, folder)
        unusual = (f"{key_path(notice.path)}: {notice.message}" for notice in limits.notices)
        mission._unusual = (*mission._unusual, *unusual)
        named = [path for name in (mission.site.files if mission.site else ()) for path in matching(name)]
        mission._sources = tuple(Path(name) for name in (*document.files, *named) if not name.startswith(REMOTE))
        return mission

    def with_(self, changes: Mapping[str, object] | None = None, /, **keys: object) -> "Mission":
        """Return the mission with changes, checked as a file is.

        Parameters
        ----------
        changes : mapping, optional
            New values by key. A key is a path (``navigation.velocity_error.sigma``, ``site.current[0].speed``), or one
            that begins with a phase's name (``ingress.speed``) or an effect (``effects.compass-bias.angle``), or a key
            alone: ``speed`` is that of every transit. A value is as in a mission file (``"1.2 m/s"``,
            ``{"mean": "1.2 m/s", "sd": "0.1 m/s"}``); a bare number is in SI; None removes the key. Paths of files are
            relative to the working directory.
        **keys : object
            Keys alone, such as ``trials=1000``.

        Raises
        ------
        InputError
            With every key that is unknown or could be several, or every problem of the changed mission.
        """
        if changes is not None and not isinstance(changes, Mapping):
            raise InputError([Problem(f"given {shown(changes)}, expected values by key", key="changes")])
        changed = changed_data(self.raw, {**(changes or {}), **keys}, type(self), self.file)
        mission = type(self).from_data(changed, file=self.file)
        mission._text, read = self._text, (*self.sources, *mission.sources)
        mission._sources = tuple(dict.fromkeys(read))
        return mission

    def with_written(self, values: Mapping[str, object]) -> "Mission":
        """Return the mission with other values at some key paths, as its file writes them; see `with_values`.

        Raises InputError as `with_values` and `from_data` do.
        """
        return Mission.from_data(with_values(self.raw, values), file=self.file)

    def to_yaml(self) -> str:
        """Return the mission as the text of a file: that which it was read from, edited where its data changed."""
        return self._text.with_data(self.raw) if self._text is not None else dumped(self.raw)

    def save(self, path: str | Path, *, force: bool = False) -> Path:
        """Write the mission to a file, with the comments of the file that it was read from.

        Into another folder a vehicle's file is written in place of its name, and the posterior's beside it.

        Parameters
        ----------
        force : bool
            Overwrite a file that is there.

        Raises
        ------
        InputError
            When the file is there already.
        RunError
            When it cannot be written.
        """
        path = as_path(path, "path")
        if exists(path) and not force:
            raise InputError([Problem("is there already", str(path), hint="force=True overwrites it")])
        text = self._text.with_data(self.raw, path.parent) if self._text is not None else dumped(self.raw)
        draws = path.parent / FILE
        stays = self._text is not None and self._text.keeps_draws(self.posterior, path.parent)
        if self.posterior is not None and not stays:
            if exists(draws) and not force and draws.read_bytes() != self.posterior.content:
                raise InputError([Problem("is there already", str(draws), hint="force=True overwrites it")])
            write_atomically(draws, self.posterior.content)
        write_atomically(path, text)
        return path

    def _from_its_start(self: "Mission") -> "Mission":
        """The mission with what it has learned among its effects, all of whose phases count from its start."""
        effects, posterior = self.effect_list, self.posterior
        start = math.nan if self.start is None else self.start.timestamp()
        latitude = self.site.origin.latitude if self.site and self.site.origin else math.nan
        if self.start is not None:
            effects = turned_effects(effects, start, latitude)
        if posterior is not None:
            effects = effects.having_learned(turned_draws(posterior.draws, start - posterior.epoch, latitude))
        longitude = self.site.origin.longitude if self.site and self.site.origin else math.nan
        date = self.dated(start)
        return self.model_copy(update={"effect_list": effects}).at_place((latitude, longitude, date), date)

    def dated(self: "Mission", date: float) -> float:
        """Return a date that counts from the mission's start; nan where that start was not moved since it learned."""
        moved = self.posterior is None or self.start is None or self.start.timestamp() != self.posterior.epoch
        return date if moved else math.nan

    def at_place(self: "Mission", here: Place, ahead: float | None = math.nan, missions: float = 1.0) -> "Mission":
        """Return the mission at a place and a date: without what was learned too far from there.

        `here`: latitude, longitude [rad] and date [s since 1970]. `ahead`: date to which the vehicle has aged; nan: as
        it is in its next mission; None: as in the last record. `missions`: instead of the next one, of such a date.
        """
        if self.posterior is None:
            return self
        effects, words = left_behind(self.effect_list, self.posterior.places, here)
        columns = effects.learned.draws.columns if effects.learned is not None else ()
        alike = still_alike(columns, self.posterior.places, here)
        effects = at_date(effects, self.posterior.seen, ahead, missions, alike)
        moved = self.model_copy(update={"effect_list": effects})
        moved._unusual = (*self._unusual, *words)
        return moved

    def knowing(self, place: str, number: int) -> Self:
        """Return the mission with an explanation of a list that is known to hold; see `EffectList.knowing`.

        The draws of everything else stay as they are.
        """
        return self.model_copy(update={"effect_list": self.effect_list.knowing(place, number)})

    def values_in_force(self) -> tuple[ValueInForce, ...]:
        """Return what is in force of every key that mission and vehicle may both give, and where it is from."""
        return tuple(values_in_force(self.raw))

    @property
    def file(self) -> str:
        """Path of the mission file, as given."""
        return self._file

    @property
    def sources(self) -> tuple[Path, ...]:
        """Every file that was read: the mission's, the vehicle's, the current's."""
        return self._sources

    @property
    def raw(self) -> Mapping[str, object]:
        """The file's own data with includes in place, as it is written to `mission.yaml` of a report."""
        return self._raw

    def identified(self) -> dict[str, object]:
        """Return `raw` with names and contents' SHA-256 in place of the paths of files: what a run of it depends on.

        Raises
        ------
        InputError
            When one of the files can no longer be read.
        """
        contents = with_contents(self.raw, self.site.files if self.site else ())
        return contents if self.posterior is None else {**contents, POSTERIOR: self.posterior["sha256"]}

    def mapped(self, change: Callable[[str, Any], _New]) -> "Mission[_New]":
        """Return the mission with every quantity changed.

        `change` goes from a quantity's name, as in `quantities`, and its value to the new value.
        """
        inside: dict[str, object] = {}
        for name, value in self:
            if name == "entries":
                inside[name] = tuple(
                    entry.model_copy(update={entry.kind: changed(entry.phase, entry.phase.name, change)})
                    for entry in self.entries
                )
            elif name == "effect_list":
                inside[name] = self.effect_list.mapped(change)
            elif name in SHARED:
                inside[name] = changed(joined(value, getattr(self.vehicle, name, None)), name, change)
            elif name not in ("sweep", "optimise", "posterior", "learned_from"):
                inside[name] = changed(value, name, change)
        return cast("Mission[_New]", self.model_copy(update=inside))

    def at(self, values: Mapping[str, Scalars]) -> "Mission[V | Scalars]":
        """Return the mission with other values for some of its quantities, by their names."""
        return self.mapped(lambda name, value: values.get(name, value))

    def at_means(self: "Mission") -> "Mission[float]":
        """Return the mission with every distribution at its mean."""
        return self.mapped(lambda _, quantity: mean_of(quantity))

    def quantities(self) -> dict[str, V]:
        """Return every quantity by its key path, phases by name: ``ingress.speed``, ``site.current[0].speed`` [SI].

        Those of a section that mission and vehicle share are named as the mission's: ``energy.hotel``.
        """
        quantities: dict[str, V] = {}

        def note(name: str, value: Any) -> Any:
            if name_in_force(name) == name:
                quantities[name] = value
            return value

        self.mapped(note)
        return quantities

    def notices(self: "Mission") -> tuple[str, ...]:
        """Return a note for each unusual value, distribution cut at its physical range, and plug-in left out."""
        return notices(self._unusual, self.uncertain())

    def uncertain(self) -> dict[str, Distribution]:
        """Return the quantities that are distributions, by key path."""
        return {path: value for path, value in self.quantities().items() if isinstance(value, Distribution)}


def with_values(data: Mapping[str, object], values: Mapping[str, object]) -> dict[str, object]:
    """Return a mission's data with other values at some key paths; sections that are missing are added.

    Raises InputError when a path leads through something that is no section.
    """
    return changed_data(data, values, Mission, in_si=False)
