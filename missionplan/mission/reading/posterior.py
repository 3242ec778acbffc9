"""The draws that a mission names as its `posterior`: read, compared with their hash, and put in their place."""

from collections.abc import Mapping
from pathlib import Path

from missionplan.effects import CATALOGUE
from missionplan.errors import KeyPath, did_you_mean, shown
from missionplan.mission.schema.section import invalid
from missionplan.montecarlo.posterior_file import MOST_BYTES, DamagedPosteriorError, PosteriorFile, sha256

KEYS = ("file", "sha256", "summary")
SIGMA = ("", "sigma_v")
"""Column of the velocity error's standard deviation."""
WITHOUT = "diagnose again writes it; without `posterior` the mission forgets what it has learned"


def posterior_of(value: object) -> PosteriorFile:
    """Return the posterior of a mission's data, as a pydantic validator does: its file is in its place already."""
    if isinstance(value, PosteriorFile):
        return value
    wrong = problem_of_section(value)
    path, message, _ = wrong or ((), "its draws were not read", "")
    raise invalid(message, path)


def problem_of_section(section: object) -> tuple[KeyPath, str, str] | None:
    """Say what is wrong with the section as written: key path, message, hint; None where nothing is."""
    if not isinstance(section, Mapping):
        return (), f"given {shown(section)}, expected {{file, sha256, summary}} as diagnose writes it", ""
    for key in section:
        if key not in KEYS:
            return (str(key),), "unknown key", did_you_mean(str(key), KEYS)
    for key in KEYS[:2]:
        if not isinstance(section.get(key), str):
            return (key,), "missing" if key not in section else f"given {shown(section[key])}, expected text", ""
    return None


def read_posterior(path: Path, section: Mapping[str, object], learned_from: object) -> PosteriorFile:
    """Read the file of a posterior.

    Parameters
    ----------
    section : mapping
        As the mission file has it.
    learned_from : object
        The mission's key of that name.

    Raises
    ------
    DamagedPosteriorError
        When it is damaged, beyond bounds, or not the one that the mission names.
    """
    content = _content(path)
    own = sha256(content)
    if own != section["sha256"]:
        raise DamagedPosteriorError(
            f"is damaged, or another mission's: its SHA-256 is {own[:12]}…, expected {str(section['sha256'])[:12]}…"
        )
    found = PosteriorFile(content)
    _check_columns(found)
    if found.learned_from != hash_of(learned_from):
        raise DamagedPosteriorError("is another mission's: it was not learned from what `learned_from` lists")
    if section.get("summary", found["summary"]) != found["summary"]:
        raise DamagedPosteriorError(
            "has another summary, which is for reading alone: an effect stated in `effects` goes before the draws"
        )
    return found


def read_draws(path: Path) -> PosteriorFile:
    """Read a file of draws by itself.

    Raises
    ------
    DamagedPosteriorError
        When it cannot be read or is none.
    """
    return PosteriorFile(_content(path))


def _content(path: Path) -> bytes:
    """Read no more of a file than a posterior may have.

    Raises
    ------
    DamagedPosteriorError
    """
    try:
        with path.open("rb") as stream:
            return stream.read(MOST_BYTES + 1)
    except OSError as error:
        raise DamagedPosteriorError(f"cannot be read: {error.strerror or error}") from error


def hash_of(learned_from: object) -> str:
    """Hash of what a mission has learned from."""
    listed = learned_from if isinstance(learned_from, list | tuple) else ()
    return sha256("\n".join(map(str, listed)).encode())


def _check_columns(found: PosteriorFile) -> None:
    """Refuse effects and values that the catalogue does not have."""
    draws = found.draws
    for effect in draws.effects:
        if effect not in CATALOGUE:
            raise DamagedPosteriorError(f"has the effect {effect!r}, which is not in the catalogue")
        own = [name for other, name in draws.columns if other == effect]
        if set(own) - set(CATALOGUE[effect].parameters):
            raise DamagedPosteriorError(f"has parameters that {effect} does not have")
    for effect, name in draws.columns:
        values, _ = draws.column((effect, name))
        low, high = (0.0, float("inf"))
        if effect:
            low, high = CATALOGUE[effect].parameters[name].low, CATALOGUE[effect].parameters[name].high
        elif (effect, name) != SIGMA:
            raise DamagedPosteriorError(f"has the column {name!r}, which means nothing here")
        margin = 1e-6 * (1.0 + abs(values).max())
        if values.min() < low - margin or values.max() > high + margin:
            raise DamagedPosteriorError(f"has values of {effect}.{name} out of its range")
