"""The two experiments that a record's gates failed: a tide in a few hours, a deviation on a part of the compass."""

import tempfile
from pathlib import Path

import numpy as np

import missionplan
from missionplan.mission import Mission

from .voyages import Truth, Voyage, mission, sail, tide, write


def short_tide(rng: np.random.Generator) -> tuple[Voyage, Voyage, Truth]:
    """M2 of 0.2 m/s on 14 legs in 3.4 h; fresh legs half a day on."""
    headings = rng.uniform(0.0, 2.0 * np.pi, 14)
    truth = Truth(("tidal-current",), (tide(0.2, rng),))
    return Voyage(headings, 820.0), Voyage(rng.uniform(0.0, 2.0 * np.pi, 24), 820.0, begins=6 * 3600.0), truth


def narrow_deviation(rng: np.random.Generator) -> tuple[Voyage, Voyage, Truth]:
    """A deviation of 5° on 24 legs within ±45° of a course; fresh legs on the way back."""
    course, phase = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.0, 2.0 * np.pi)
    truth = Truth(("compass-deviation",), turn=lambda t, heading: np.radians(5.0) * np.sin(heading + phase))
    out = course + rng.uniform(-0.25, 0.25, 24) * np.pi
    back = course + np.pi + rng.uniform(-0.25, 0.25, 24) * np.pi
    return Voyage(out), Voyage(back, begins=24 * 960.0), truth


def constant_current(rng: np.random.Generator) -> tuple[Voyage, Voyage, Truth]:
    """A steady current in a record of 72 minutes."""
    angle = rng.uniform(0.0, 2.0 * np.pi)
    flow = 0.15 * np.array([np.sin(angle), np.cos(angle)])
    truth = Truth(("mean-current",), (lambda t, place: flow,))
    return (
        Voyage(rng.uniform(0.0, 2.0 * np.pi, 24), 150.0, 30.0),
        Voyage(rng.uniform(0, 6.28, 24), 150.0, 30.0, begins=4320.0),
        truth,
    )


def one(kind, seed: int) -> dict[str, object]:
    """Diagnose one record; score base and extended mission on fresh legs all the way."""
    rng = np.random.default_rng(seed)
    voyage, fresh, truth = kind(rng)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        base = Mission.from_data(mission(voyage))
        found = missionplan.diagnose(base, write(folder / "seen", sail(voyage, truth, rng), 3.0), plan=False)
        later = write(folder / "fresh", sail(fresh, truth, rng), 3.0)
        found.save(folder / "out")
        scored = []
        for m in (base, missionplan.load(folder / "out" / "mission.yaml")):
            score = missionplan.score(m, later)
            whole = score.summary()["datasets"][0]["predictions"]["whole"]
            scored.append(
                (whole["rmse"], whole["coverage_90"]["value"], whole["coverage_50"]["value"], whole["log_score"])
            )
    return {"found": found, "truth": truth, "base": scored[0], "extended": scored[1]}


def main() -> None:
    for kind, count in ((short_tide, 7), (narrow_deviation, 6), (constant_current, 3)):
        for seed in range(count):
            got = one(kind, 41000 + seed)
            f, truth = got["found"], got["truth"]
            hold = truth.names in f.credible_set or any(set(truth.names) == set(c) for c in f.credible_set)
            top = [("+".join(r.causes), round(r.posterior or 0, 3)) for r in f.ranking[:3]]
            b, e = got["base"], got["extended"]
            print(
                f"{kind.__name__:18s} {seed} {f.verdict:16s} {'+'.join(f.causes) or '-':34s} truth in set {hold!s:5} n={len(f.credible_set)} "
                f"rmse {b[0]:.0f}->{e[0]:.0f} ({e[0] / b[0]:.2f}) cov90 {e[1]:.2f} cov50 {e[2]:.2f} ls {b[3]:.2f}->{e[3]:.2f} nott {f.none_of_these:.2f} {top}",
                flush=True,
            )


if __name__ == "__main__":
    main()
