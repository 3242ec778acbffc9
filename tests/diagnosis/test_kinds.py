"""Every kind of data can be read, diagnosed and reported; what is no kind is refused."""

from pathlib import Path

import pytest

from missionplan.diagnosis.data_kind import KINDS, DataKind, bind_dataset, kind_named
from missionplan.diagnosis.inference.model import Model
from missionplan.effects import CATALOGUE
from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.report.diagnosis.kinds import REPORTS

MISSIONS = Path(__file__).parents[2] / "missions"


def test_every_kind_of_data_set_is_diagnosed_and_reported() -> None:
    assert set(KINDS) == set(REPORTS)
    for name in KINDS:
        assert issubclass(kind_named(name), DataKind)


def test_instruments_measure_parameters_of_the_catalogue() -> None:
    instruments = {info.id: info.instrument for info in CATALOGUE.values() if info.instrument is not None}
    assert instruments
    for effect, instrument in instruments.items():
        assert instrument.parameter in CATALOGUE[effect].parameters
        assert instrument.sd > 0.0


@pytest.mark.parametrize(("name", "kind"), [("avila-drag", "drag"), ("table-1", "summary")])
def test_a_data_set_is_bound_as_its_kind(name: str, kind: str) -> None:
    bound = bind_dataset(MISSIONS / "measured" / name, load(MISSIONS / "chesapeake.yaml"), seed=1)
    model: Model = bound.model
    assert bound.kind == kind
    assert type(bound) is kind_named(kind)
    assert model.candidates


def test_another_kind_is_refused_with_those_that_are_known(tmp_path: Path) -> None:
    (tmp_path / "dataset.yaml").write_text("kind: sonar\nfile: rows.csv\n")
    with pytest.raises(InputError, match=r"sonar.*transit.*descent.*summary"):
        bind_dataset(tmp_path, load(MISSIONS / "fig8.yaml"), seed=1)


def test_a_summary_is_ambiguous_at_best() -> None:
    bound = bind_dataset(MISSIONS / "measured" / "table-1", load(MISSIONS / "chesapeake.yaml"), seed=1)
    assert bound.limited_verdict("explained") == "ambiguous"
    assert bound.limited_verdict("adequate") == "adequate"
