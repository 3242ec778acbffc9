"""Array types of the numerical core, with a few small helpers, and roots of functions, one a trial."""

from dataclasses import fields, is_dataclass, replace
from typing import Protocol, Self, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Scalars = float | Array
"""A number, or an array over trials."""
Value = TypeVar("Value")


class Normals(Protocol):
    """Standard normals of a quantity that is drawn anew for each leg."""

    def leg(self, number: int) -> Array:
        """Normals of a leg, from 0, shape (2, at least n)."""
        ...


def magnitude(value: Scalars) -> Scalars:
    """Absolute value, a float of a float: stepped models run five times faster on Python's floats than on numpy's."""
    return np.abs(value) if isinstance(value, np.ndarray) else abs(value)


def over_trials(value: Scalars, trials: int) -> Array:
    """Return a number, or an array over trials, as a read-only array of shape (n,)."""
    return np.broadcast_to(np.asarray(value, dtype=float), (trials,))


def row_and_next(grid: Array, row: NDArray[np.intp]) -> tuple[Array, Array]:
    """Values of a grid, shape (m, n), at a row index of each trial and at the row after it, shape (k, n) each."""
    trials = grid.shape[1]
    flat = row * trials + np.arange(trials)
    return grid.take(flat), grid.take(flat + trials)


def take_trials(value: Value, trials: NDArray[np.intp], *, alike: bool = False) -> Value:
    """Select trials of an array, whose last axis they are, or of every array in a data class or tuple; numbers stay.

    `alike`: so do arrays of length 1, where all trials are alike.
    """
    if isinstance(value, np.ndarray) and value.ndim:
        return value if alike and value.shape[-1] == 1 else cast("Value", value[..., trials])
    if isinstance(value, tuple):
        return cast("Value", tuple(take_trials(item, trials, alike=alike) for item in value))
    if is_dataclass(value) and not isinstance(value, type):
        whole = {field.name: getattr(value, field.name) for field in fields(value)}
        taken = {name: take_trials(item, trials, alike=alike) for name, item in whole.items()}
        changed = {name: item for name, item in taken.items() if item is not whole[name]}
        return replace(value, **changed) if changed else value
    return value


_NINES = [sign * float(f"{'9' * digits}{rest}") for digits in (3, 4, 5, 6) for rest in ("", ".9", ".99")
          for sign in (-1.0, 1.0) if digits > 3 or sign < 0.0]  # fmt: skip
_FILLED = 1e19
"""Size from which on a number stands for none."""


def without_nines(values: Array) -> Array:
    """Put nan for -999, -9999, 9999, 1e20 and the like, by which loggers write that they have no value."""
    return np.where(np.isin(values, _NINES) | (np.abs(values) >= _FILLED), np.nan, values)


_MOST = 90
"""Evaluations after which the search ends: thirty of them halve the bracket."""


class FallingFunctions(Protocol):
    """Functions, one per trial, that fall from positive to negative values; they may jump."""

    def evaluate(self, place: Array) -> tuple[Array, Array]:
        """Values at places of shape (n,), and proposed steps from there to the roots."""
        ...

    def take(self, trials: NDArray[np.intp]) -> Self:
        """Select trials."""
        ...


def bracketed_roots(functions: FallingFunctions, low: Array, high: Array, start: Array, *, tolerance: float) -> Array:
    """Find where functions cross zero.

    A proposed step (Newton's, or that of a fixed point) is taken where it stays within the bracket and is at most half
    of the last one; else the bracket is halved, so that a poor proposal costs time but no root (Press et al. 2007,
    Numerical Recipes, sect. 9.4). Roots that are found are not evaluated again.

    Parameters
    ----------
    low, high : array, shape (n,)
        Brackets. A function that is negative throughout gives `low`, one that is positive throughout `high`.
    start : array, shape (n,)
        First places.
    tolerance : float
        Of the places.

    Returns
    -------
    array, shape (n,)
    """
    roots = np.clip(start, low, high)
    left, place, moved = np.arange(roots.size), roots, high - low
    for _ in range(_MOST):
        value, step = functions.evaluate(place)
        low, high = np.where(value >= 0.0, place, low), np.where(value <= 0.0, place, high)
        proposed = np.clip(place + step, low, high)
        open_ = (np.abs(step) >= tolerance) & (high - low >= tolerance)
        roots[left] = np.where(open_, place, proposed)
        if not open_.any():
            break
        halved = (proposed <= low) | (proposed >= high) | (np.abs(step) > 0.5 * moved)
        onward = np.where(halved, 0.5 * (low + high), proposed)
        moved, place = np.abs(onward - place), onward
        if not open_.all():
            kept = np.flatnonzero(open_)
            functions, left = functions.take(kept), left[kept]
            place, low, high, moved = place[kept], low[kept], high[kept], moved[kept]
    return roots
