"""Depths of a model's layers below the surface of the moment, and how deep a column of water is good."""

import re
from collections.abc import Callable, Mapping

import numpy as np

from missionplan.arrays import Array
from missionplan.phases.recorded_currents import DEPTH_MARGIN, DEPTH_SHARE
from missionplan.scenario.currents.attributes import (
    PARAMETRIC,
    FieldAttributeError,
    depths,
    is_dimensionless,
    is_vertical,
    scale,
    word,
)
from missionplan.scenario.currents.files import FieldFiles

SKIN = 1.0
"""Depth down to which a current that is given for the surface alone is good [m]."""
BOTTOM = ("h", "depth", "bathymetry", "deptho")
SURFACE = ("zeta", "elev", "elevation", "ssh", "zos")
SEAFLOOR = ("sea_floor_depth_below_geoid", "sea_floor_depth", "sea_floor_depth_below_sea_surface")
SEAFLOOR_ALSO = ("sea_floor_depth_below_mean_sea_level", "sea_floor_depth_below_reference_ellipsoid")
HEIGHT = ("sea_surface_height_above_geoid", "sea_surface_height", "sea_surface_height_above_mean_sea_level")
_DEPTHS = ("depth", "height", "altitude")
"""Begin the standard names of vertical axes."""
_DEEPEST = 12_000.0
"""No sea is as deep [m]."""
At = Callable[..., Array]
"""Values of a variable, by its name, at the columns of a field: shape (c,), or (t, c) where it changes in time.

With the dimension of the levels as well: (d, c) or (t, d, c).
"""
_TERMS: Mapping[str, tuple[str, ...]] = {
    "ocean_sigma_coordinate": ("sigma",),
    "ocean_s_coordinate": ("s", "a", "b", "depth_c"),
    "ocean_s_coordinate_g1": ("s", "C", "depth_c"),
    "ocean_s_coordinate_g2": ("s", "C", "depth_c"),
}
"""Terms of each coordinate that no column changes; `depth` and `eta` come to them."""


def parametric_depths(kind: str, terms: Mapping[str, Array], bottom: Array, surface: Array) -> Array:
    """Depths of levels that follow bottom and surface, below the surface of the moment, shape (t, c, d) [m].

    CF 1.11, appendix D; of the last two kinds Shchepetkin and McWilliams 2005, Ocean Modelling 9, 347-404, Eqs. 2.1 and
    2.2, with ROMS's ``Vtransform`` 1 and 2.

    Parameters
    ----------
    kind : str
        Of `PARAMETRIC`.
    terms : mapping
        Of the formula, by CF's names: `sigma`, `s` and `C` of shape (d,), -1 at the bottom to 0 at the surface, and the
        numbers `a`, `b` and `depth_c` [m].
    bottom : array, shape (c,)
        Depth of the seafloor below the datum [m].
    surface : array, shape (t, c)
        Its height above the datum [m].
    """
    h, zeta = bottom[:, None], surface[:, :, None]
    if kind == "ocean_sigma_coordinate":
        return np.asarray(-terms["sigma"] * (h + zeta))
    s, critical = terms["s"], terms["depth_c"]
    if kind == "ocean_s_coordinate":
        a, b = terms["a"], terms["b"]
        stretching = (1.0 - b) * np.sinh(a * s) / np.sinh(a) + b * (
            np.tanh(a * (s + 0.5)) / (2.0 * np.tanh(0.5 * a)) - 0.5
        )
        return np.asarray(-(zeta * s + critical * s + (h - critical) * stretching))
    stretching = terms["C"]
    if kind == "ocean_s_coordinate_g1":
        unmoved = critical * (s - stretching) + h * stretching
        return np.asarray(-(unmoved + zeta * unmoved / h))
    return np.asarray(-(zeta + h) * (critical * s + h * stretching) / (critical + h))


def level_depths(files: FieldFiles, along: str, at: At, times: int) -> tuple[Array, Array | None]:
    """Depths of the levels along a dimension, by the attributes of its vertical axis.

    Raises InputError or FieldAttributeError when nothing says where they are, or what is said cannot be used.

    `at`: values at the field's columns. `times`: of the field.

    Returns
    -------
    levels, bottom : array, array or None
        Of shape (d,), or (t, c, d) with to what depth each column is good, shape (c,) [m].
    """
    name = _axis(files, along)
    roms = files.named("Cs_r") and (along in ("s_rho", "sc_r") or files.named("s_rho"))
    if name is not None and is_dimensionless(files.variable(name)) and not (roms and _lacks(files, name)):
        kind, terms, names = _by_formula(files, name)
        otherwise = ""
    elif roms:
        kind, terms, names, otherwise = *_by_roms(files, along), "m"
    elif cells := _in_each_column(files, name, along):
        return _levels_of_columns(files, cells, at(cells, along), times), None
    elif name is None:
        raise files.problem(f"nothing says at what depths the levels along {along} are")
    else:
        return _fixed_levels(files, name, along), None
    bottom = depths(files.variable(names[0]), at(names[0]), otherwise)
    bottom = np.where(np.isfinite(bottom), bottom, SKIN)  # of land, where no level has a value
    if bottom.ndim > 1:
        bottom = bottom[0]
    surface = np.zeros((times, bottom.size))
    if names[1]:
        surface = surface + np.nan_to_num(at(names[1]).astype(float)) * files.height_factor(names[1], otherwise)
    return parametric_depths(kind, terms, bottom, surface), good_down_to(bottom + surface.max(axis=0))


def _axis(files: FieldFiles, along: str) -> str | None:
    """Name of the vertical axis of a dimension: the coordinate itself if its attributes say so, else one that does."""
    names = [
        str(name)
        for dataset in files.datasets
        for name in (along, *dataset.variables)
        if name in dataset.variables and dataset[name].dims == (along,) and is_vertical(dataset[name])
    ]
    if names:
        return names[0]
    return along if files.named(along) else files.named("depth", "Depth", "lev", "z")


def _in_each_column(files: FieldFiles, axis: str | None, along: str) -> str | None:
    """Name of depths that each column has of its own: a coordinate, or any variable where nothing else has depths."""
    has_axis = axis is not None and files.variable(axis).dims == (along,) and bool(word(files.variable(axis), "units"))
    for dataset in files.datasets:
        for name in dataset.coords if has_axis else dataset.variables:
            is_depth = "positive" in dataset[name].attrs or word(dataset[name], "standard_name").startswith(_DEPTHS)
            if dataset[name].ndim > 1 and along in dataset[name].dims and is_depth:
                return str(name)
    return None


def _levels_of_columns(files: FieldFiles, name: str, values: Array, times: int) -> Array:
    """Depths of levels that each column has of its own, shape (t, c, d); those below its bottom are at its deepest."""
    depth = depths(files.variable(name), values).swapaxes(-1, -2)
    deepest = np.max(depth, axis=-1, keepdims=True, where=np.isfinite(depth), initial=0.0)
    depth = np.where(np.isfinite(depth), depth, deepest)
    order = np.diff(depth, axis=-1)
    if depth.min() < 0.0 or depth.max() > _DEEPEST or not (np.all(order >= 0.0) or np.all(order <= 0.0)):
        raise files.problem(f"{name} has depths above the surface or below all seas, or that neither rise nor fall")
    return np.broadcast_to(depth, (times, *depth.shape[-2:]))


def _fixed_levels(files: FieldFiles, name: str, along: str) -> Array:
    depth = files.depths(name)
    if depth.ndim != 1 or depth.size == 0 or not np.isfinite(depth).all():
        raise files.problem("expected one-dimensional time, depth, latitude and longitude")
    if depth.size != files.size(along):
        raise files.problem(f"the depths along {along} are not one a layer")
    if depth.min() < 0.0:
        hint = "does its attribute `positive` say the right way?"
        raise files.problem(f"{name} lies {-float(depth.min()):.4g} m above the surface", hint)
    order = np.diff(depth)
    if not (np.all(order > 0.0) or np.all(order < 0.0)):
        raise files.problem("its depths neither rise nor fall")
    return depth


def _written_terms(files: FieldFiles, name: str) -> dict[str, str]:
    return dict(re.findall(r"(\w+)\s*:\s*([^\s:]+)(?!\S*:)", word(files.variable(name), "formula_terms")))


def _lacks(files: FieldFiles, name: str) -> bool:
    """Whether terms of a formula are not in the file, as in those that were cut from ROMS's."""
    written = _written_terms(files, name)
    return not written or any(files.named(variable) is None for variable in written.values())


def _by_formula(files: FieldFiles, name: str) -> tuple[str, dict[str, Array], tuple[str, str | None]]:
    """Kind and terms of a coordinate, and the names of the depth of the bottom and of the surface's height."""
    kind, written = word(files.variable(name), "standard_name").lower(), _written_terms(files, name)
    if kind not in PARAMETRIC:
        words = kind or "coordinate without standard_name"
        raise FieldAttributeError(f"{name} is a {words}, which cannot be computed; expected {', '.join(PARAMETRIC)}")
    absent = [variable for variable in written.values() if files.named(variable) is None]
    if absent:
        raise FieldAttributeError(f"the formula_terms of {name} name {absent[0]}, which the file lacks")
    if not written:  # the axis itself is the first term, and standard names tell the other two
        first = {_TERMS[kind][0]: name}
        bottom = files.named(standard=(*SEAFLOOR, *SEAFLOOR_ALSO))
        surface = files.named(standard=HEIGHT)
        written = first | ({"depth": bottom} if bottom else {}) | ({"eta": surface} if surface else {})
    missing = [term for term in (*_TERMS[kind], "depth") if term not in written]
    if missing:
        raise FieldAttributeError(f"{name} is an {kind} whose formula_terms lack {', '.join(missing)}")
    terms = {term: files.fixed(written[term]) for term in _TERMS[kind]}
    if "depth_c" in terms:
        terms["depth_c"] = terms["depth_c"] * scale(files.variable(written["depth_c"]), "m", "a length such as m")
    return kind, _checked(files, terms), (written["depth"], written.get("eta"))


def _by_roms(files: FieldFiles, along: str) -> tuple[str, dict[str, Array], tuple[str, str | None]]:
    """Return the same by the names that ROMS gives."""
    s = files.required("the s-coordinate", along, "s_rho", "sc_r")
    critical = files.required("the critical depth", "hc")
    name = files.named("Vtransform")
    standard = word(files.variable(s), "standard_name").lower()
    transform = (2 if standard == PARAMETRIC[3] else 1) if name is None else round(float(files.fixed(name)))
    if transform not in (1, 2):
        raise files.problem(f"Vtransform is {transform}; expected 1 or 2")
    terms = {
        "s": files.fixed(s),
        "C": files.fixed(files.required("the stretching of the s-coordinate", "Cs_r")),
        "depth_c": files.fixed(critical) * files.height_factor(critical, "m"),
    }
    bottom = files.required("the depth of the bottom", *BOTTOM)
    return f"ocean_s_coordinate_g{transform}", _checked(files, terms), (bottom, files.named(*SURFACE))


def _checked(files: FieldFiles, terms: dict[str, Array]) -> dict[str, Array]:
    """Refuse levels that no column of water has.

    Raises InputError when they do not lie between the bottom and the surface, or neither rise nor fall.
    """
    levels = [terms[name] for name in ("sigma", "s", "C") if name in terms]
    if any(term.ndim != 1 or term.size != levels[0].size for term in levels):
        raise files.problem("its s-coordinate and the stretching of it are not one number a layer")
    if any(not np.all((term >= -1.0) & (term <= 0.0)) for term in levels):
        raise files.problem("its s-coordinate and the stretching of it do not lie between -1 and 0")
    if any(not (np.all(np.diff(term) > 0.0) or np.all(np.diff(term) < 0.0)) for term in levels):
        raise files.problem("its s-coordinate neither rises nor falls")
    return terms


def good_down_to(depth: Array | float) -> Array:
    """Depth to which a column is good that reaches down to a depth [m]: as records are, see `DEPTH_MARGIN`."""
    return np.asarray(depth + np.maximum(DEPTH_MARGIN, DEPTH_SHARE * np.asarray(depth)))
