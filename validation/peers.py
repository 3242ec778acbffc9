"""Rows against peer programs, run in the same environment; ``pip install 'missionplan[validation]'`` brings them."""

import contextlib
import io
import math
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
from scipy.stats import norm

from benchmarks import line as moordyn_lines
from missionplan.mission import Mission
from missionplan.montecarlo.rare_events import NormalPopulation
from missionplan.montecarlo.sensitivity import sensitivities
from missionplan.phases.mooring.pitch_over import NOSE_DOWN
from missionplan.physics.held_line import HeldLine, hang
from missionplan.physics.line_statics import held_pose
from missionplan.physics.propeller import Resistance, from_open_water
from missionplan.physics.water import lamb_axial_coefficient, lamb_lateral_coefficient
from missionplan.studies.simulation.simulate import simulate
from missionplan.studies.tide.harmonic_analysis import Constituent, tidal_velocity
from tests.montecarlo import test_rare_events as rare
from tests.phases.mooring import test_descent as dives
from tests.phases.mooring import test_pitch_over as turning
from tests.phases.mooring import tied_reference
from tests.physics import test_line_statics as lines
from tests.physics.propeller_example import simulate_propulsion
from validation.rows import Measured, NotMeasurableHereError, Options, at_least, at_most, between, reported, row


def peer(module: str) -> Any:
    """Import a peer program.

    Raises
    ------
    NotMeasurableHereError
        When it is not installed.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return import_module(module)
    except ImportError:
        raise NotMeasurableHereError(f"{module} is not installed") from None


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """Let a library that is not Python's print to nowhere."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


@row(
    "peer.scipy-dive",
    "A dive of the prototype, stage after stage",
    case="100 ft, drag by Eqs. 2 to 13, default step",
    reference="`solve_ivp`, DOP853 at 10⁻¹², events included",
    accepted=[at_most("touchdown away", 1e-5, "s"), at_most("lowest altitude away", 1e-5, "m")],
)
def _scipy_dive(_: Options) -> list[float]:
    from benchmarks.descent import DIVE, one_by_one

    record, exact = dives.run(DIVE), one_by_one(DIVE, "DOP853", 1e-12)
    return [abs(float(record.descent_time[0]) - exact[0]), abs(float(record.lowest_altitude[0]) - exact[1])]


@row(
    "peer.scipy-tied-drift",
    "The line ties the drift of anchor and vehicle together",
    case="50 cases: 8 to 60 m deep, lines of 2 to 12 m, layers of −0.2 to 1.2 m/s",
    reference="`solve_ivp` of Lagrange's equations in the line's angle",
    seed=2026,
    accepted=[
        at_most("greatest difference of the offset", 0.01, "of it, or 1 cm"),
        at_most("touchdown away", 0.002, "of its time"),
    ],
    cost=60.0,
)
def _scipy_tied_drift(_: Options) -> Measured:
    from missionplan.report.page import style
    from tests.phases.mooring import test_tied_drift as drift

    pairs, times = [], []
    for number in range(50):
        case = tied_reference.varied_case(number)
        exact = tied_reference.tied(case)
        record = drift.run(drift.dive_of(case), case.down_to, case.speed, release=case.release)
        pairs.append((exact.offset, float(record.offset[0, 0])))
        times.append(abs(float(record.descent_time[0]) / exact.time - 1.0))
    away = max(max(abs(b - a) - 0.01, 0.0) / max(abs(a), 1e-9) for a, b in pairs)
    with style():
        import matplotlib.pyplot as plt

        figure, axes = plt.subplots(figsize=(4.5, 3.6), layout="constrained")
        ends = [min(min(p) for p in pairs), max(max(p) for p in pairs)]
        axes.plot(ends, ends, color="0.6", linewidth=1.0)
        axes.plot(*np.array(pairs).T, "o", markersize=4)
        axes.set(xlabel="offset by solve_ivp [m]", ylabel="offset by missionplan [m]")
        plt.close(figure)
    return Measured([away, max(times)], figure)


@row(
    "peer.scipy-pitch-over",
    "The taut line turns the vehicle nose down",
    case="four vehicles, anchors of 8 to 25 N, lines of 3 to 10 m",
    reference="`solve_ivp` of Lagrange's equations, mass matrix differentiated numerically",
    accepted=[at_most("time away", 5e-3, "s"), at_most("depth of the nose away", 5e-3, "m")],
    cost=10.0,
)
def _scipy_pitch_over(_: Options) -> list[float]:
    times, depths = [], []
    assert math.isclose(NOSE_DOWN, math.radians(80.0))
    for centre, ahead, below, weight, line in (
        (0.56, 0.0, 0.0, 11.7, 5.0),
        (0.57, 0.01, -0.008, 11.7, 5.0),
        (0.45, -0.005, -0.005, 8.0, 3.0),
        (0.65, 0.0, -0.01, 25.0, 10.0),
    ):
        body = replace(turning.BODY, centre=centre, ahead=ahead, below=below)
        dive = replace(turning.DIVE, wet_weight=weight, line_length=line)
        found = turning.turned(dive, body, step=0.02)
        time, depth = turning.reference(dive, body, turning.lone_fall(dive).speed[0])
        times.append(abs(float(found.stage.time[0]) - time))
        depths.append(abs(float(found.stage.depth[0]) - depth))
    return [max(times), max(depths)]


@row(
    "peer.scipy-moored-line",
    "The nose of a moored vehicle on a line that stretches, floats, sinks and lies",
    case="40 cases: five currents, eight lines of 0 to 8 mm, −0.03 to 0.55 N/m, 3 to 6 m",
    reference="shooting from the nose with `solve_ivp` and quadrature",
    accepted=[at_most("noses apart, greatest", 4e-3, "of the line"), reported("in the median", "of the line")],
    cost=60.0,
)
def _scipy_moored_line(_: Options) -> list[float]:
    apart = []
    for low, shear in ((0.05, 0.0), (0.1, 0.03), (0.2, 0.0), (0.25, -0.02), (0.5, 0.0)):
        for width, weight, stiffness, length in lines.LINES:
            compliance = 1.0 / (stiffness * length) if stiffness else 0.0
            line = lines.rope(length, width, wet_weight=weight, compliance=compliance)
            pose = held_pose(lines.body(), line, lines.sheared(low, shear))
            place, _load = lines.shot_from_the_nose(line, lambda z, a=low, b=shear: a + b * np.asarray(z))
            apart.append(float(np.hypot(*(pose.nose[[0, 2], 0] - place))) / length)
    return [max(apart), float(np.median(apart))]


@row(
    "peer.moordyn-moored-line",
    "The nose of a moored vehicle",
    case="eight of the 40 cases of `benchmarks.line`: five currents, eight lines of other weight, stretch and length",
    reference="MoorDyn, 20 segments, dynamic relaxation",
    packages=("moordyn",),
    accepted=[at_most("noses apart, greatest", 2e-3, "of the line"), reported("in the median", "of the line")],
    cost=50.0,
)
def _moordyn(_: Options) -> list[float]:
    return _apart_from_moordyn([(rope, ()) for rope in moordyn_lines.LINES], every=5)


@row(
    "peer.moordyn-floats",
    "The nose of a vehicle on a line with floats, partly on the seafloor",
    case="40 cases: five currents, eight lines with one to three floats, 23 touching the seafloor before a float",
    reference="MoorDyn, 20 segments, dynamic relaxation",
    packages=("moordyn",),
    accepted=[at_most("noses apart, greatest", 2e-2, "of the line"), reported("in the median", "of the line")],
    cost=120.0,
)
def _moordyn_floats(_: Options) -> list[float]:
    return _apart_from_moordyn(moordyn_lines.FLOATED)


def _apart_from_moordyn(lines_with_floats: Sequence[tuple[Any, Any]], every: int = 1) -> list[float]:
    from itertools import product

    peer("moordyn")
    cases = list(product(moordyn_lines.CURRENTS, lines_with_floats))[::every]
    with _silent():
        found = [moordyn_lines.apart(current, *case) for current, case in cases]
    return [max(found), float(np.median(found))]


@row(
    "peer.moorpy-line",
    "The tension with which a heavy line bears a body in still water",
    case="60 draws of lines of 5 m, 0.05 to 2 N/m, EA 50 to 5000 N, ends 3 to 4.8 m apart, without slack ones",
    reference="MoorPy's catenary",
    packages=("MoorPy",),
    seed=4,
    accepted=[at_most("greatest difference of the place", 1e-4, "of the line")],
)
def _moorpy(_: Options) -> list[float]:
    catenary, rng, worst, length = peer("moorpy.Catenary").catenary, np.random.default_rng(4), 0.0, 5.0
    for _number in range(60):
        apart, angle = rng.uniform(3.0, 4.8), rng.uniform(0.3, 1.3)
        weight, stiffness = rng.uniform(0.05, 2.0), 10.0 ** rng.uniform(1.7, 3.7)
        across, up = apart * math.cos(angle), apart * math.sin(angle)
        with contextlib.redirect_stdout(io.StringIO()):
            _, _, horizontal, vertical, _ = catenary(across, up, length, stiffness, weight, CB=0.0, Tol=1e-9)
        if horizontal > -1e-6:  # slack: where it lies is not determined
            continue
        line = HeldLine(length, wet_weight=weight, compliance=1.0 / stiffness)
        pull = np.array([[-horizontal], [0.0], [-vertical]])  # MoorPy's are forces on the body
        hung = hang(line, lines.uniform(0.0), np.array([up]), pull)
        worst = max(worst, float(np.hypot(*(hung.fallen[-1, [0, 2], 0] - [across, up]))) / length)
    return [worst]


@row(
    "peer.utide-forecast",
    "A tide forecast from constituents",
    case="M2, S2, K1 and O1 of 0.4 to 0.06 m/s at 37.2° N, 60 days by the half-hour",
    reference="UTide `reconstruct`, nodal corrections at each time",
    packages=("utide",),
    accepted=[at_most("greatest difference", 2e-3, "m/s")],
)
def _utide(_: Options) -> list[float]:
    utide = peer("utide")
    waves = [
        Constituent("M2", 0.4, -0.1, 0.6, 1.2),
        Constituent("S2", 0.15, 0.05, 2.5, 4.0),
        Constituent("K1", 0.1, 0.02, 1.0, 0.3),
        Constituent("O1", 0.06, 0.0, 0.2, 5.0),
    ]
    seconds = 1_780_000_000.0 + np.arange(0.0, 60.0 * 86400.0, 1800.0)
    found = tidal_velocity(waves, seconds, math.radians(37.2))
    days = seconds / 86400.0 + 719163.0
    with contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        names = [wave.name for wave in waves]
        options = {
            "lat": 37.2,
            "constit": names,
            "nodal": "exact",
            "trend": False,
            "conf_int": "none",
            "verbose": False,
        }
        fitted = utide.solve(days, *found, epoch="python", method="ols", **options)
        again = utide.reconstruct(days, fitted, epoch="python", verbose=False)
    return [float(np.abs(np.stack((again.u, again.v)) - found).max())]


@row(
    "peer.salib-first-order",
    "First-order indices from the trials at hand",
    case="Ishigami, 16 384 trials; a linear model of three inputs",
    reference="SALib `rbd_fast` on the same trials",
    packages=("SALib",),
    seed=12,
    accepted=[at_most("greatest difference", 0.02)],
)
def _salib(_: Options) -> list[float]:
    rbd, rng, worst = peer("SALib.analyze.rbd_fast"), np.random.default_rng(12), 0.0
    names = ["x1", "x2", "x3"]
    x = rng.uniform(-math.pi, math.pi, (3, 16_384))
    problem = {"num_vars": 3, "names": names, "bounds": [[-math.pi, math.pi]] * 3}
    ishigami = np.sin(x[0]) + 7.0 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])
    for y in (ishigami, 3.0 * x[0] - 2.0 * x[1] + x[2]):
        theirs = rbd.analyze(problem, x.T, y, print_to_console=False, num_resamples=2, seed=1)["S1"]
        ours = {each.source: each.first_order for each in sensitivities(dict(zip(names, x, strict=True)), {"y": y})}
        worst = max(worst, *(abs(ours[name] - float(other)) for name, other in zip(names, theirs, strict=True)))
    return [worst]


@row(
    "peer.openturns-series",
    "A series system of two parts at 10⁻⁶",
    case="limit ±4.9, six runs, mean",
    reference="OpenTURNS `SubsetSampling`, 10⁵ a level, and the closed form",
    packages=("openturns",),
    seed=0,
    accepted=[between("over the closed form", 0.85, 1.15), between("OpenTURNS over the closed form", 0.8, 1.25)],
    cost=20.0,
)
def _openturns_series(_: Options) -> list[float]:
    ot = peer("openturns")
    margin, truth = rare.series_system(4.9, 2)
    ours = np.mean([rare.run(margin, seed, groups=10, chains=256)[2].value for seed in range(6)])
    ot.RandomGenerator.SetSeed(1)
    g = ot.SymbolicFunction(["a", "b"], ["4.9 - max(abs(a), abs(b))"])
    vector = ot.CompositeRandomVector(g, ot.RandomVector(ot.Normal(2)))
    algorithm = ot.SubsetSampling(ot.ThresholdEvent(vector, ot.Less(), 0.0))
    algorithm.setMaximumOuterSampling(100_000)
    algorithm.setBlockSize(1)
    algorithm.run()
    return [float(ours) / truth, algorithm.getResult().getProbabilityEstimate() / truth]


_HARD = 1e-9
"""Problems less likely are left out: their printed probabilities have one digit."""


@row(
    "peer.openturns-problems",
    "The reliability problems that methods are compared on",
    case="every problem of otbenchmark from 10⁻⁹ to 0.1 in up to 20 dimensions, one run of 10 × 256 chains each",
    reference="otbenchmark's reference probabilities; FORM of OpenTURNS beside",
    packages=("openturns", "otbenchmark"),
    seed=5,
    accepted=[
        at_least("problems", 15.0),
        at_least("within a half of the reference", 0.85, "of them"),
        at_most("median ratio away from one", 0.1),
        reported("FORM within a half of the reference", "of them"),
    ],
    cost=60.0,
)
def _openturns_problems(_: Options) -> Measured:
    ot = peer("openturns")
    ot.Log.Show(ot.Log.NONE)
    if not hasattr(ot, "ComposedDistribution"):  # the name until OpenTURNS 1.24, which otbenchmark uses
        ot.ComposedDistribution = ot.JointDistribution
    benchmark, names, ours, forms = peer("otbenchmark"), [], [], []
    for problem in _problems(benchmark):
        truth, event = float(problem.getProbability()), problem.getEvent()
        distribution = event.getAntecedent().getDistribution()
        if not _HARD < truth < 0.1 or distribution.getDimension() > 20:
            continue
        try:
            found = rare.run(_margin_of(event), 5, groups=10, chains=256)[2].value
        except TypeError:  # formulas that this version of OpenTURNS does not parse
            continue
        names.append(problem.getName())
        ours.append(found / truth)
        forms.append(_form(ot, event) / truth)
    ratios = np.array(ours)
    close = float(np.mean(np.abs(np.log(np.maximum(ratios, 1e-30))) < math.log(1.5)))
    form = float(np.mean(np.abs(np.log(np.maximum(np.array(forms), 1e-30))) < math.log(1.5)))
    figure = _ratios(names, ours, forms)
    return Measured([float(len(names)), close, float(abs(np.median(ratios) - 1.0)), form], figure)


def _problems(benchmark: Any) -> Iterator[Any]:
    for name in sorted(dir(benchmark)):
        if name.startswith(("ReliabilityProblem", "RminusS", "FourBranch", "AxialStressed")):
            yield getattr(benchmark, name)()


def _margin_of(event: Any) -> Callable[[NormalPopulation], np.ndarray]:
    """Distance of an event's function from its threshold, of standard normals."""
    back = event.getAntecedent().getDistribution().getInverseIsoProbabilisticTransformation()
    function, threshold = event.getFunction(), event.getThreshold()
    sign = 1.0 if event.getOperator()(0.0, 1.0) else -1.0  # fails below the threshold, or above

    def margin(population: NormalPopulation) -> np.ndarray:
        u = population.cell("u", 0, event.getAntecedent().getDistribution().getDimension())
        return sign * (np.asarray(function(back(u.T)))[:, 0] - threshold)

    return margin


def _form(ot: Any, event: Any) -> float:
    start = event.getAntecedent().getDistribution().getMean()
    solver = ot.AbdoRackwitz()
    solver.setMaximumIterationNumber(200)
    solver.setStartingPoint(start)
    algorithm = ot.FORM(solver, event)
    try:
        algorithm.run()
    except (RuntimeError, TypeError):
        return math.nan
    return float(algorithm.getResult().getEventProbability())


def _ratios(names: list[str], ours: list[float], forms: list[float]) -> Any:
    import matplotlib.pyplot as plt

    from missionplan.report.page import style

    with style():
        figure, axes = plt.subplots(figsize=(6.4, 0.22 * len(names) + 1.0), layout="constrained")
        places = np.arange(len(names))
        axes.axvline(1.0, color="0.6", linewidth=1.0)
        axes.plot(np.clip(forms, 1e-2, 1e2), places, "x", color="0.4", label="FORM (OpenTURNS)")
        axes.plot(np.clip(ours, 1e-2, 1e2), places, "o", markersize=5, label="missionplan")
        axes.set(xscale="log", xlabel="probability over the reference", yticks=places, yticklabels=names)
        axes.legend()
        plt.close(figure)
    return figure


@row(
    "peer.monaco-transit",
    "Mean duration of a transit of uncertain speed",
    case="7.4 km in four legs or more, 1.25 ± 0.05 m/s, 4096 cases and 65 536 trials",
    reference="monaco, which runs a plain Python function case by case",
    packages=("monaco",),
    seed=1,
    accepted=[at_most("difference", 4.0, "standard errors")],
    cost=30.0,
)
def _monaco(_: Options) -> list[float]:
    import yaml

    from benchmarks.transit_trial import MISSION, SPEED, SPEED_SD, transit_trial

    monaco, durations = peer("monaco"), []

    def run(speed: float, seed: int) -> tuple[float, int]:
        durations.append(transit_trial(speed, seed)[0])
        return durations[-1], 0

    functions = {
        "preprocess": lambda case: (case.invals["speed"].val, case.seed),
        "run": run,
        "postprocess": lambda case, duration, _: case.addOutVal("duration", duration),
    }
    with contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sim = monaco.Sim("transit", 4096, functions, seed=1, singlethreaded=True, verbose=False, debug=True)
        sim.addInVar("speed", norm, {"loc": SPEED, "scale": SPEED_SD})
        sim.runSim()
    found = (
        simulate(Mission.from_data(yaml.safe_load(MISSION)), trials=65_536, seed=1).phases[0].quantities["duration_s"]
    )
    theirs = np.array(durations[-4096:])
    error = math.hypot(found.standard_error, float(theirs.std()) / 64.0)
    return [abs(found.mean - float(theirs.mean())) / error]


@row(
    "peer.fossen-added-mass",
    "Added masses of the REMUS 100",
    case="spheroid of 1.6 m by 0.19 m",
    reference="Fossen (2021), 8.4.2, as printed: k₁ and k₂",
    accepted=[at_most("k₁ away", 1e-9), at_most("k₂ away", 1e-9), reported("k₁"), reported("k₂")],
)
def _fossen_added_mass(_: Options) -> list[float]:
    fineness = 1.6 / 0.19
    e = math.sqrt(1.0 - fineness**-2)
    logarithm = math.log((1.0 + e) / (1.0 - e))
    along = 2.0 * (1.0 - e**2) / e**3 * (0.5 * logarithm - e)
    across = 1.0 / e**2 - (1.0 - e**2) / (2.0 * e**3) * logarithm
    exact = along / (2.0 - along), across / (2.0 - across)
    found = float(lamb_axial_coefficient(fineness)), float(lamb_lateral_coefficient(fineness))
    return [abs(found[0] - exact[0]), abs(found[1] - exact[1]), *found]


@row(
    "peer.fossen-top-speed",
    "Top speed of the REMUS 100 from its propeller and drag",
    case="1525 rev/min, K_T 0.4566 to 0.1798 at J = 0.6632, C_d 0.42, t = 0.1, w = 0.056",
    reference="Fossen's vehicle simulator: balance of its thrust and drag; its text says 2.5 m/s",
    accepted=[at_most("away from the balance", 1e-3, "m/s"), between("top speed", 2.3, 2.7, "m/s")],
)
def _fossen_top_speed(_: Options) -> list[float]:
    density, diameter, turns = 1026.0, 0.14, 1525.0 / 60.0
    slope_t, slope_q = (0.1798 - 0.4566) / 0.6632, (0.0312 - 0.0700) / 0.6632
    quadratic = 0.5 * density * 0.42 * math.pi * (0.19 / 2.0) ** 2
    static = 0.9 * density * diameter**4 * 0.4566 * turns**2
    lost = 0.9 * density * diameter**3 * slope_t * 0.944 * turns
    balance = (lost + math.sqrt(lost**2 + 4.0 * quadratic * static)) / (2.0 * quadratic)
    unit = replace(
        from_open_water(
            diameter,
            (0.4566, slope_t),
            (0.0700, slope_q),
            density=density,
            wake_fraction=0.056,
            thrust_deduction=0.1,
        ),
        flow_mass=1e4,
        flow_damping_quadratic=1e5,  # the flow in the disc is then the advance speed, as the simulator has it
    )
    rate = 2.0 * math.pi * turns
    run = simulate_propulsion(unit, Resistance(31.9, 0.0, quadratic), np.zeros(3000), 0.02, (rate, 2.0, 2.0))
    return [abs(float(run.speed[-1]) - balance), float(run.speed[-1])]
