"""The validation table: every row is well formed, and the pages show what was measured."""

import json
import math
from dataclasses import replace

import typer

from benchmarks import table
from benchmarks.common import Circumstances, Section
from benchmarks.common import Row as SpeedRow
from missionplan.cli import app
from missionplan.results.decision import RANGES, ROWS_OF_COMMAND, Assumption
from validation import pages, record
from validation.__main__ import SHOWN, main
from validation.rows import LEVELS, PAGES, ROOT, Accepted, Measured, Options, Row, all_rows, at_most, near


def made(accepted, values, **more):
    return Row("closed.made", "A claim", "a case", "a reference", tuple(accepted), lambda _: Measured(values), **more)


def judged(row, tmp_path):
    return record.measured(row, Options(tmp_path, tmp_path), figures=None)


def test_every_row_is_of_a_level_and_says_its_claim_case_and_reference():
    rows = all_rows()
    assert {each.level for each in rows.values()} == set(LEVELS)
    for name, each in rows.items():
        assert each.name == name
        assert each.claim
        assert each.case
        assert each.reference
        assert each.accepted
        assert any(number.is_limited for number in each.accepted), f"{name} cannot fail"
        assert len({number.name for number in each.accepted}) == len(each.accepted), name


def test_a_number_outside_its_limits_fails_the_row(tmp_path):
    assert judged(made([at_most("x", 1.0, "m")], [0.9]), tmp_path).verdict == record.HOLDS
    assert judged(made([at_most("x", 1.0, "m")], [1.1]), tmp_path).verdict == record.FAILS
    assert judged(made([near("x", 1.0, 0.1)], [math.nan]), tmp_path).verdict == record.FAILS
    assert judged(made([near("x", 1.0, 0.1)], [1.0], differs="known"), tmp_path).verdict == record.DIFFERS
    assert judged(made([near("x", 1.0, 0.1)], [2.0], differs="known"), tmp_path).verdict == record.FAILS
    assert Accepted("x").holds(math.nan)


def test_a_row_that_breaks_fails_and_the_others_go_on(tmp_path):
    found = judged(made([at_most("x", 1.0)], [1.0, 2.0]), tmp_path)
    assert found.verdict == record.FAILS
    assert "ValueError" in found.why


def test_the_pages_show_all_that_was_measured():
    shown = {name: pages.page(name) for name in SHOWN}
    assert not any(pages.MARK.search(text) or "**fails**" in text for text in shown.values())
    for each in all_rows().values():
        assert f"| {each.claim} | {each.case} |" in shown[PAGES[each.level]]
    for record_of_speed in json.loads(table.STORE.read_text(encoding="utf-8")).values():
        assert all(f"| {row['what']} | {row['ours']} |" in shown["speed"] for row in record_of_speed["rows"])


def test_measuring_again_leaves_the_lines_of_other_rows(tmp_path, monkeypatch):
    kept = {path.name: path.read_bytes() for path in record.STORE.glob("*.json") if path != table.STORE}
    found = record.load()
    monkeypatch.setattr(record, "STORE", tmp_path)
    record.save(dict(reversed(found.items())))
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == kept
    record.save({**found, "fault.kill": replace(found["fault.kill"], cpu_s=1.5)})
    assert record.load()["fault.kill"].cpu_s == 1.5
    changed = set((tmp_path / "faults.json").read_bytes().splitlines()) - set(kept["faults.json"].splitlines())
    assert changed == {b'  "cpu_s": 1.5,'}


def test_a_comparison_is_written_down_in_place_of_what_it_was(tmp_path, monkeypatch):
    monkeypatch.setattr(table, "STORE", tmp_path / "speed.json")
    table.STORE.write_text("{}", encoding="utf-8")
    section = Section(
        (SpeedRow("a b", "2 s", "1 s", "2 × as long", "≤ 1.5", met=False), SpeedRow("c", "3 s")), notes=("N.",)
    )
    measured = Circumstances("2026-11-28", ("2 × X", "1 GiB"), ("Python 3",), 0.5)
    table.write("made", replace(section, rows=()), measured)
    table.write("made", section, measured)
    assert table.as_markdown(*table.load("made")) == table.as_markdown(section, measured)
    assert table.as_markdown(section, measured).endswith(
        "| a b | 2 s | 1 s | 2 × as long | ≤ 1.5 | **no** |\n| c | 3 s |  |  |  |  |\n\nN.\n"
        "Measured 2026-11-28, 2 × X, 1 GiB, Python 3, load average 0.5 before."
    )


def test_reports_name_rows_and_commands_that_there_are():
    rows = all_rows()
    commands = typer.main.get_command(app).commands
    assert {name.split()[0] for name in ROWS_OF_COMMAND} <= set(commands)
    named = {each for several in ROWS_OF_COMMAND.values() for each in several}
    assert named | {each for checked in RANGES.values() for each in checked.rows} <= set(rows)


def test_the_ledger_of_every_shipped_mission_is_printed(monkeypatch, capsys):
    turned = Assumption("there is no wind", "winds", -0.6, 0.4, ("out.arrived",))
    monkeypatch.setattr("validation.__main__.ledger", lambda mission, seed: (turned,))
    assert main(["--assumptions"]) == 0
    rows = [line.split(" | ") for line in capsys.readouterr().out.splitlines()[2:]]
    assert [row[0] for row in rows] == [f"| {path.stem}" for path in sorted((ROOT / "missions").glob("*.yaml"))]
    assert rows[0][3:5] == ["40.0 %", "-60.0 %"]
    assert rows[0][5] == "out.arrived |"
