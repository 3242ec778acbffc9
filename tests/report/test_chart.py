"""A chart behind the map of the site: GeoJSON and GeoTIFF from local files, and what cannot be read told on the map."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image, TiffImagePlugin

from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.report.page import style
from missionplan.report.site_map import site_map

pytestmark = pytest.mark.usefixtures("drawn")

MISSIONS = Path(__file__).parents[2] / "missions"
WEST, NORTH = -76.39, 37.26


def geojson(path: Path) -> None:
    def feature(kind, coordinates, **properties):
        return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}

    land = [[[-76.385, 37.252], [-76.370, 37.254], [-76.370, 37.260], [-76.385, 37.260], [-76.385, 37.252]]]
    contour = [[-76.385, 37.249], [-76.372, 37.2495], [-76.360, 37.249]]
    features = [feature("Polygon", land), feature("LineString", contour, depth=10)]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))


def geotiff(path: Path) -> None:
    """Write 40 by 20 pixels of 0.001 deg by 0.001 deg: red west of the middle, green east of it."""
    pixels = np.zeros((20, 40, 3), dtype=np.uint8)
    pixels[:, :20, 0] = pixels[:, 20:, 1] = 255
    tags = TiffImagePlugin.ImageFileDirectory_v2()
    tags.tagtype[33550] = tags.tagtype[33922] = 12
    tags[33550] = (0.001, 0.001, 0.0)
    tags[33922] = (0.0, 0.0, 0.0, WEST, NORTH, 0.0)
    tags.tagtype[34735] = 3
    tags[34735] = (1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 4326)
    Image.fromarray(pixels).save(path, tiffinfo=tags)


def mission(folder: Path, chart: str):
    data = yaml.safe_load((MISSIONS / "chesapeake.yaml").read_text())
    data["vehicle"] = yaml.safe_load((MISSIONS / "vehicles" / "vt475-self-mooring.yaml").read_text())
    data["site"]["chart"] = chart
    (folder / "mission.yaml").write_text(yaml.safe_dump(data, sort_keys=False))
    return load(folder / "mission.yaml")


@pytest.mark.parametrize(("name", "write"), [("coast.geojson", geojson), ("chart.tif", geotiff)])
def test_a_chart_is_drawn_behind_the_site(tmp_path, name, write):
    write(tmp_path / name)
    loaded = mission(tmp_path, name)
    assert tmp_path / name in loaded.sources
    with style():
        plain, drawn = site_map({**loaded.raw, "site": {"origin": loaded.raw["site"]["origin"]}}), site_map(loaded.raw)
    assert f"Chart: {name}; not for navigation." in drawn.caption
    assert len(drawn.svg) > len(plain.svg)
    assert ("data:image/png" in drawn.svg) == (name == "chart.tif")
    assert ("10\u00a0m" in drawn.svg) == (name == "coast.geojson")


def test_names_stand_on_white_before_a_picture_in_colours_of_their_own(tmp_path):
    geotiff(tmp_path / "chart.tif")
    data = mission(tmp_path, "chart.tif").raw
    with style():
        drawn, plain = site_map(data), site_map({**data, "site": {"origin": data["site"]["origin"]}})
    assert re.search(r"fill: #ffffff; opacity: 0.8", drawn.svg)
    assert "opacity: 0.8" not in plain.svg
    scale = drawn.svg[drawn.svg.index(">200\u00a0m<") - 300 : drawn.svg.index(">200\u00a0m<")]
    assert "#222222" not in scale


def test_a_chart_that_cannot_be_read_is_told_and_the_map_is_drawn(tmp_path):
    (tmp_path / "coast.geojson").write_text("[1, 2")
    with style():
        drawn = site_map(mission(tmp_path, "coast.geojson").raw)
    assert "The chart coast.geojson cannot be read as GeoJSON: JSONDecodeError" in drawn.caption


def test_a_chart_that_is_missing_or_has_no_place_is_refused(tmp_path):
    with pytest.raises(InputError, match="there is no such file"):
        mission(tmp_path, "coast.geojson")
    (tmp_path / "coast.pdf").write_text("")
    with pytest.raises(InputError, match=r"GeoJSON .* or GeoTIFF"):
        mission(tmp_path, "coast.pdf")
