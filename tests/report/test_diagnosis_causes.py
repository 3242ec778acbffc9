"""What the report of a diagnosis says of the causes themselves."""

from types import SimpleNamespace
from typing import Any

import pytest

from missionplan.effects import CATALOGUE
from missionplan.report.diagnosis.kind_report import causes_section, found_causes, names, part
from missionplan.results.learned.evidence import ParameterEstimate


def diagnosed(*causes: str, rivals: tuple[tuple[str, ...], ...] = ()) -> Any:
    return SimpleNamespace(causes=causes, rivals=rivals)


@pytest.mark.parametrize("cause", CATALOGUE)
def test_every_cause_of_the_catalogue_is_described(cause: str) -> None:
    (section,) = causes_section(diagnosed(cause))
    (words,) = section.blocks
    info = CATALOGUE[cause]
    assert section.heading == "What such a cause is"
    assert all(part in words for part in (info.what, info.sizes, info.distinguished_by[1:]))
    assert all(names((other,)) in words for other in info.confused_with)


def test_causes_that_would_do_as_well_follow_once_each() -> None:
    (section,) = causes_section(diagnosed("sensor-lag", rivals=(("clock-offset",), ("clock-offset", "drag-bias"))))
    assert section.heading == "What such causes are"
    assert [str(words).split(".")[0] for words in section.blocks] == ["Sensor lag", "Clock offset", "Drag bias"]


def test_nothing_is_described_where_nothing_is_claimed() -> None:
    assert causes_section(diagnosed()) == []


@pytest.mark.parametrize(
    ("amplitude", "words"),
    [
        (0.15, "compass deviation and mean current"),
        (0.2, "an error that depends on heading, as a compass deviation would and mean current"),
    ],
)
def test_a_deviation_beyond_ten_degrees_is_not_called_that_of_a_compass(amplitude: float, words: str) -> None:
    found = ParameterEstimate("compass-deviation", "amplitude", amplitude, 0.02, amplitude - 0.03, amplitude, "rad")
    assert found_causes(("compass-deviation", "mean-current"), (found,)) == words


@pytest.mark.parametrize(("share", "told"), [(1.0, "> 99 %"), (0.9951, "> 99 %"), (0.994, "99 %"), (0.0, "0 %")])
def test_a_part_is_never_told_to_be_all(share: float, told: str) -> None:
    assert part(share) == told
