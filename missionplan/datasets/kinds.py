"""The kinds of data sets: a new kind has a module of its own and a line here."""

from collections.abc import Mapping

from missionplan.datasets.dives import DESCENT
from missionplan.datasets.legs import TRANSIT
from missionplan.datasets.reading import DatasetFormat, DatasetSettings
from missionplan.datasets.summaries import SUMMARY
from missionplan.datasets.tank import TANK_FORMATS

FORMATS: Mapping[str, DatasetFormat[DatasetSettings]] = {
    form.kind: form for form in (TRANSIT, DESCENT, *TANK_FORMATS.values(), SUMMARY)
}
TANK_KINDS = tuple(TANK_FORMATS)
