"""GeoPackage (OGC 12-128): waypoints, courses and circles as layers, for QGIS and other programs; needs pyogrio."""

import json
import tempfile
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from missionplan.errors import InputError, Problem
from missionplan.exporters import header, one_interval
from missionplan.exporters.geojson import Feature, features
from missionplan.exporters.kml import properties_of
from missionplan.identity import how_to_install
from missionplan.results.plan import Plan

TITLE = "GeoPackage"
NEEDS_ORIGIN = True
lost = one_interval

_LAYERS = {
    "waypoints": ("waypoint", "mooring"),
    "courses": ("planned track",),
    "circles": ("arrival circle", "mooring circle"),
    "zones": ("land", "keep-out"),
}
"""Kinds of features of each layer."""


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write one file with the layers `waypoints`, `courses`, `circles` and `zones`; their metadata hold the header.

    Raises InputError when pyogrio is not installed.
    """
    try:
        import_module("pyogrio")
    except ImportError as error:
        raise InputError([Problem(f"needs pyogrio: {how_to_install('gpkg')}", key="to")]) from error
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{stem}.gpkg"
        for name, kinds in _LAYERS.items():
            layer = [_plain(feature) for feature in features(plan) if properties_of(feature)["kind"] in kinds]
            if layer:
                _layer(path, plan, name, layer)
        return {path.name: path.read_bytes()}


def _plain(feature: Feature) -> Feature:
    """Return a feature with the columns of its layer: no colours, a waypoint's own kind, no name that the rest says."""
    kept = properties_of(feature)
    if kept["kind"] == "waypoint":
        kept["kind"] = kept.pop("waypoint")
    elif kept["kind"] not in ("mooring", *_LAYERS["zones"]):
        del kept["name"]
    if kept["kind"] == "planned track":
        del kept["kind"]
    return {**feature, "properties": kept}


def _layer(path: Path, plan: Plan, name: str, features: Sequence[Feature]) -> None:
    """Write a layer: GDAL reads the features as GeoJSON and writes them as they are."""
    from pyogrio import raw

    collection = json.dumps({"type": "FeatureCollection", "features": features}).encode()
    meta, _, geometry, columns = raw.read(collection)
    kinds = {feature["geometry"]["type"] for feature in features}
    several = any(kind.startswith("Multi") for kind in kinds)
    raw.write(
        path,
        geometry=geometry,
        field_data=columns,
        fields=meta["fields"],
        layer=name,
        driver="GPKG",
        geometry_type=max(kinds, key=len),
        promote_to_multi=several,
        crs="EPSG:4326",
        append=path.exists(),
        layer_metadata={"header": "\n".join(header(plan, TITLE, lost(plan))), "mission_sha256": plan.digest},
    )
