"""The file beside an extended mission: draws of what was learned, what was seen of levels, and where and when."""

import hashlib
import io
import json
import math
import zipfile
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from missionplan.montecarlo.levels import Seen
from missionplan.montecarlo.posterior import NOWHERE, Place, WeightedDraws

FILE = "posterior.npz"
"""Name of the file beside the mission that names it."""
FORMAT = 2
MOST_BYTES, MOST_UNPACKED = 8_000_000, 64_000_000
"""Of the file, and of each of its members unpacked."""
MOST_DRAWS, MOST_COLUMNS, MOST_SETS, MOST_SEEN = 50_000, 200, 500, 20_000
_MEMBERS: Mapping[str, tuple[str, int]] = {
    "format": ("i", 0),
    "effects": ("U", 1),
    "sets": ("b", 2),
    "which": ("i", 1),
    "columns": ("U", 2),
    "values": ("f", 2),
    "weights": ("f", 1),
    "learned_from": ("U", 0),
    "epoch": ("f", 0),
    "place": ("f", 1),
    "seen_of": ("U", 2),
    "seen": ("f", 2),
    "summary": ("U", 0),
}
"""Kind and number of dimensions of each array of the file."""


class DamagedPosteriorError(ValueError):
    """A file that holds no posterior: says what is wrong."""


class PosteriorFile(Mapping[str, object]):
    """A posterior as a mission's data hold it: what the mission file says of it, with the draws themselves.

    Parameters
    ----------
    content : bytes
        Of the file.

    Raises
    ------
    DamagedPosteriorError
        When it is none.
    """

    def __init__(self, content: bytes) -> None:
        self.content = content
        self.draws, self.learned_from, self.epoch, self.place, self.seen, summary = _read(content)
        self.section: Mapping[str, object] = {"file": FILE, "sha256": sha256(content), "summary": summary}

    @classmethod
    def of(
        cls,
        draws: WeightedDraws,
        learned_from: str,
        summary: Mapping[str, object],
        epoch: float = math.nan,
        place: Place = NOWHERE,
        seen: Sequence[Seen] = (),
    ) -> "PosteriorFile":
        """Write draws.

        Parameters
        ----------
        learned_from : str
            Hash of what they were learned from.
        summary : mapping
            For the reader.
        epoch : float
            Date from which phases count [s since 1970].
        place : tuple of float
            Latitude, longitude [rad] and date [s since 1970] at which they were learned.
        seen : sequence of Seen
            What each record has told of the levels of the vehicle's parameters.
        """
        effects = draws.effects
        held = np.array([[effect in own for effect in effects] for own in draws.sets], dtype=bool)
        written = io.BytesIO()
        np.savez_compressed(
            written,
            format=np.array(FORMAT),
            effects=np.array(effects, dtype=str),
            sets=held.reshape(len(draws.sets), len(effects)),
            which=draws.which.astype(np.int32),
            columns=np.array(draws.columns, dtype=str).reshape(-1, 2),
            values=draws.values.astype(np.float32),
            weights=draws.weights.astype(np.float64),
            learned_from=np.array(learned_from),
            epoch=np.array(epoch),
            place=np.array(place),
            seen_of=np.array([(*each.of, each.record) for each in seen], dtype=str).reshape(-1, 4),
            seen=np.array([(each.date, each.value, each.sd) for each in seen], dtype=float).reshape(-1, 3),
            summary=np.array(json.dumps(summary, ensure_ascii=False)),
        )
        return cls(written.getvalue())

    def __getitem__(self, key: str) -> object:
        return self.section[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.section)

    def __len__(self) -> int:
        return len(self.section)

    def __deepcopy__(self, memo: object) -> "PosteriorFile":
        return self  # nothing in it changes

    def __reduce__(self) -> tuple[type["PosteriorFile"], tuple[bytes]]:
        return type(self), (self.content,)


def sha256(content: bytes) -> str:
    """Hash of a file's content."""
    return hashlib.sha256(content).hexdigest()


def _read(content: bytes) -> tuple[WeightedDraws, str, float, Place, tuple[Seen, ...], Mapping[str, object]]:
    """Read draws, the hash of what they were learned from, the date of phases, the place, levels, and the summary.

    Raises
    ------
    DamagedPosteriorError
    """
    arrays = _arrays(content)
    if int(arrays["format"]) != FORMAT:
        raise DamagedPosteriorError(f"has format {int(arrays['format'])}, expected {FORMAT}")
    try:
        summary = json.loads(str(arrays["summary"]))
    except (ValueError, RecursionError):
        raise DamagedPosteriorError("holds no summary") from None
    effects, held = arrays["effects"].tolist(), arrays["sets"]
    n, k = arrays["values"].shape
    shapes = len(arrays["which"]) == len(arrays["weights"]) == n > 0 and arrays["columns"].shape == (k, 2)
    if not shapes or held.shape[1] != len(effects) or not isinstance(summary, dict):
        raise DamagedPosteriorError("holds arrays of unlike lengths")
    if n > MOST_DRAWS or k > MOST_COLUMNS or not 0 < len(held) <= MOST_SETS:
        raise DamagedPosteriorError(f"holds {n} draws of {len(held)} sets, too many to be one of diagnose")
    sets = tuple(tuple(name for name, own in zip(effects, row, strict=True) if own) for row in held)
    draws = WeightedDraws(
        sets,
        arrays["which"].astype(int),
        tuple((str(effect), str(name)) for effect, name in arrays["columns"].tolist()),
        arrays["values"].astype(float),
        arrays["weights"].astype(float),
    )
    _check(draws)
    if arrays["place"].shape != (3,):
        raise DamagedPosteriorError("is damaged: it names no place")
    latitude, longitude, date = (float(each) for each in arrays["place"])
    found = draws, str(arrays["learned_from"]), float(arrays["epoch"]), (latitude, longitude, date)
    return *found, _seen(arrays["seen_of"], arrays["seen"]), summary


def _seen(of: NDArray[np.generic], rows: NDArray[np.generic]) -> tuple[Seen, ...]:
    """Read what records have told of levels.

    Raises
    ------
    DamagedPosteriorError
    """
    if of.shape != (len(rows), 4) or rows.shape[1] != 3 or len(rows) > MOST_SEEN:
        raise DamagedPosteriorError("is damaged: what it has seen of levels is not what diagnose writes")
    numbers = rows.astype(float)
    if not np.all(np.isfinite(numbers[:, 1:])) or np.any(numbers[:, 2] <= 0.0):
        raise DamagedPosteriorError("is damaged: it has seen levels that are no numbers")
    return tuple(
        Seen((str(effect), str(name), str(kind)), str(record), *values)
        for (effect, name, kind, record), values in zip(of.tolist(), numbers.tolist(), strict=True)
    )


def _arrays(content: bytes) -> dict[str, NDArray[np.generic]]:
    if len(content) > MOST_BYTES:
        raise DamagedPosteriorError(f"has {len(content)} bytes, expected at most {MOST_BYTES}")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as packed:
            sizes = {entry.filename.removesuffix(".npy"): entry.file_size for entry in packed.infolist()}
        if set(sizes) != set(_MEMBERS) or max(sizes.values()) > MOST_UNPACKED:
            raise DamagedPosteriorError("does not hold what diagnose writes")
        with np.load(io.BytesIO(content), allow_pickle=False) as loaded:
            arrays = {name: loaded[name] for name in _MEMBERS}
    except DamagedPosteriorError:
        raise
    except Exception as error:  # zipfile, zlib and numpy raise what they like on damaged bytes
        raise DamagedPosteriorError("is damaged: cannot be read") from error
    for name, (kind, dimensions) in _MEMBERS.items():
        if arrays[name].dtype.kind != kind or arrays[name].ndim != dimensions:
            raise DamagedPosteriorError(f"is damaged: {name} is not what diagnose writes")
    return arrays


def _check(draws: WeightedDraws) -> None:
    """Refuse draws that are no distribution."""
    which, weights = draws.which, draws.weights
    if which.min() < 0 or which.max() >= len(draws.sets) or np.any(np.diff(which) < 0):
        raise DamagedPosteriorError("is damaged: its draws are of no set")
    if len(np.unique(which)) < len(draws.sets) or len(set(draws.columns)) < len(draws.columns):
        raise DamagedPosteriorError("is damaged: a set has no draws, or a column is there twice")
    if not np.all(weights > 0.0) or not math.isclose(float(weights.sum()), 1.0, abs_tol=1e-6):
        raise DamagedPosteriorError("is damaged: its weights are no probabilities")
    for index, (effect, name) in enumerate(draws.columns):
        holds = np.array([not effect or effect in held for held in draws.sets])[which]
        if not np.array_equal(np.isfinite(draws.values[:, index]), holds):
            raise DamagedPosteriorError(f"is damaged: {effect}.{name} has values that are no numbers")
