"""The fingerprint covers all that a number depends on."""

import importlib.metadata
import sys

import numpy as np

from missionplan.montecarlo.parallel import fingerprint as module


def digest(monkeypatch, tmp_path, text):
    (tmp_path / "fouling.py").write_text(text)
    entry = importlib.metadata.EntryPoint("fouling", "fouling:INFO", "missionplan.effects")
    monkeypatch.setattr(module, "entry_points", lambda group: [entry])
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    return module.fingerprint.__wrapped__()


def test_versions_of_numpy_and_scipy_are_in_it():
    assert f"numpy {np.__version__}" in module.fingerprint()
    assert "scipy" in module.fingerprint()


def test_the_source_of_a_plugin_is_in_it_and_it_is_not_run(monkeypatch, tmp_path):
    first = digest(monkeypatch, tmp_path, "raise SystemExit\n")
    second = digest(monkeypatch, tmp_path, "raise SystemExit  # other\n")
    assert "effects of fouling" in first
    assert first != second


def test_a_plugin_whose_source_is_gone_is_said(monkeypatch):
    entry = importlib.metadata.EntryPoint("gone", "no_such_package:INFO", "missionplan.effects")
    monkeypatch.setattr(module, "entry_points", lambda group: [entry])
    assert "effects of no_such_package missing" in module.fingerprint.__wrapped__()
