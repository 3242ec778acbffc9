"""`verify`: the same bits, or which are not and what differs."""

import dataclasses
import json
import shutil
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

import missionplan
from missionplan import InputError, Mission, verify
from missionplan import verification as module
from missionplan.cli import app
from missionplan.exporters import format_named
from missionplan.identity import running_program
from missionplan.montecarlo.statistics import Probability
from missionplan.results.failures import Counted
from missionplan.store.checkpoints import Checkpoints, read_block
from missionplan.studies.export import mission_plan
from missionplan.studies.simulation import simulate as simulation
from tests.fixtures import TRANSIT

TRIALS = 3 * 4096 + 10


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "report"
    mission = Mission.from_data(TRANSIT)
    missionplan.simulate(mission, trials=TRIALS, seed=3, sheet=False, checkpoint=folder / "blocks").save(
        folder, force=True
    )
    return folder


@pytest.fixture
def report(made, tmp_path):
    return shutil.copytree(made, tmp_path / "report")


def rewrite(report, block, size):
    """Change the last bit of one number of a block, and sign it."""
    arrays = read_block(report / "blocks", block, size)
    digest = str(arrays.pop("digest"))
    name = next(name for name, values in arrays.items() if values.dtype == float and values.size)
    arrays[name] = arrays[name].copy()
    arrays[name].flat[0] += 1e-12
    store = object.__new__(Checkpoints)
    store._folder, store._digest = report / "blocks", digest
    store.write(block, size, arrays)
    return name


def test_some_blocks_come_out_the_same(report):
    before = {path: path.read_bytes() for path in report.rglob("*") if path.is_file()}
    found = verify(report)
    assert found.same
    assert found.unlike == ()
    assert found.computed == "3 of 4 blocks computed again"
    assert found.values > 1000
    assert str(found).startswith("The same bits come out here: ")
    assert {path: path.read_bytes() for path in report.rglob("*") if path.is_file()} == before


def test_a_mission_as_exported_comes_out_the_same(tmp_path):
    folder = tmp_path / "report"
    mission = Mission.from_data(TRANSIT)
    run = {"trials": 200, "seed": 3, "as_exported": "moos", "checkpoint": folder / "blocks"}
    missionplan.simulate(mission, **run).save(folder, force=True)
    assert verify(folder).same
    assert verify(folder, all_blocks=True).same


def test_what_files_lose_is_told_beside_what_the_mission_means(monkeypatch):
    def counted(**shares):
        counts = {Counted.event(key.replace("_", ".")): share for key, share in shares.items()}
        return {each: Probability(share, share, share) for each, share in counts.items()}

    def meant(mission, *, trials, seed):
        assert (trials, seed) == (300, 7)
        return counted(total_success=0.912, out_arrived=0.95, out_limited=0.1)

    monkeypatch.setattr(simulation, "event_probabilities", meant)
    carried = counted(total_success=0.634, out_arrived=0.7, out_limited=0.2)
    counts = {each: SimpleNamespace(probability=lambda share=share: share) for each, share in carried.items()}
    merged, mission = SimpleNamespace(totals=SimpleNamespace(trials=300, counts=counts)), Mission.from_data(TRANSIT)
    plan = mission_plan(mission, to="moos")
    words, *lost = simulation._loss(mission, ("moos", plan), merged, 7)
    assert words == (
        "As the vehicle carries out its moos files: total success 63.4% of trials, as the mission means it 91.2%; "
        "out arrived 70.0% of trials, as the mission means it 95.0%."
    )
    assert lost == [f"Not in its files: {each}." for each in format_named("moos").lost(plan)]


@pytest.mark.parametrize("option", [{"sheet": False}, {"assumptions": True}, {"precision": "success=0.2"}], ids=str)
def test_what_a_report_was_asked_for_is_asked_for_again(option, tmp_path):
    folder = tmp_path / "report"
    run = {"trials": 50, "seed": 3, "checkpoint": folder / "blocks", **option}
    missionplan.simulate(Mission.from_data(TRANSIT), **run).save(folder, force=True)
    found = verify(folder, all_blocks=True)
    assert found.different == ()
    assert found.values > 100


def test_one_bit_of_a_block_is_found_where_that_block_is_computed(report):
    name = rewrite(report, 1, 4096)
    assert verify(report).same  # the first, the third and the last of four are
    (line,) = verify(report, all_blocks=True).different
    assert line.startswith(f"block 1, {name}: 1 of ")
    name = rewrite(report, 3, 10)
    assert verify(report).different[0].startswith(f"block 3, {name}: 1 of ")


def test_a_number_changed_in_the_summary_is_found_by_all(report):
    summary = json.loads((report / "summary.json").read_text())
    summary["total"]["quantities"]["duration_s"]["mean"] += 1.0
    (report / "summary.json").write_text(json.dumps(summary))
    found = verify(report, all_blocks=True)
    (line,) = found.different
    assert line.startswith("total.quantities.duration_s.mean: was ")
    assert "the machines compute differently" in str(found)


def test_a_changed_mission_is_named(report):
    text = (report / "mission.yaml").read_text()
    (report / "mission.yaml").write_text(text.replace("0.03 m/s", "0.04 m/s"))
    found = verify(report)
    assert not found.same
    assert found.unlike == ("mission.yaml or a file that it names: not as it was when the report was made",)


def test_other_code_is_named_and_harms_nothing_where_the_bits_are_the_same(report, monkeypatch):
    other = dataclasses.replace(
        running_program(), code="0" * 64, libraries={**running_program().libraries, "scipy": "9"}
    )
    monkeypatch.setattr(module, "running_program", lambda: other)
    found = verify(report)
    assert found.same
    assert [line.partition(":")[0] for line in found.unlike] == ["code of missionplan", "library scipy"]


def test_a_forged_identity_is_named(report):
    summary = json.loads((report / "summary.json").read_text())
    (report / "summary.json").write_text(json.dumps({**summary, "identity": "0" * 64}))
    assert verify(report).unlike == ("identity: not that of its parts; summary.json has been changed",)


@pytest.mark.parametrize(
    "study",
    [
        lambda mission: missionplan.sweep_dmax(mission, trials=20, method="monte-carlo"),
        lambda mission: missionplan.explore(mission, "out.speed=1:2:1 m/s", trials=20),
        pytest.param(
            lambda mission: missionplan.find_rare_failure(mission, event="out.duration > 3 h", trials=2000),
            marks=pytest.mark.slow,
        ),
    ],
    ids=["sweep-dmax", "explore", "rare"],
)
def test_other_studies_are_computed_again_as_a_whole(study, tmp_path):
    study(Mission.from_data(TRANSIT)).save(tmp_path / "report")
    found = verify(tmp_path / "report")
    assert found.same, found.different
    assert found.unlike == ()
    assert found.computed == "the study computed again"


def test_what_reads_reports_is_refused(report, tmp_path):
    missionplan.compare(report, report).save(tmp_path / "compared")
    with pytest.raises(InputError, match=r"was made by compare; reports of simulate, .* can be computed again"):
        verify(tmp_path / "compared")
    with pytest.raises(InputError, match="no such folder"):
        verify(tmp_path / "none")


def test_the_command_says_it_and_exits_with_3_where_other_bits_come_out(report):
    done = CliRunner().invoke(app, ["verify", str(report), "--jobs", "1"])
    assert done.exit_code == 0
    assert "The same bits come out here: 3 of 4 blocks" in done.output
    rewrite(report, 0, 4096)
    done = CliRunner().invoke(app, ["verify", str(report), "--jobs", "1", "--json"])
    assert done.exit_code == 3
    answer = json.loads(done.stdout)
    assert not answer["same"]
    assert answer["different"][0].startswith("block 0, ")
