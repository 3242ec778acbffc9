"""The position errors that the vehicle's own drift compensation would have expected on the legs of a log."""

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.records import TransitData
from missionplan.mission import Mission
from missionplan.phases.transit.compensation import CompletedLeg, PlannedLeg
from missionplan.phases.transit.kalman_filter import DriftFilter
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current


def expected_by_vehicle(data: TransitData, mission: Mission) -> list[Array] | None:
    """Run the mission's drift compensation along a log; expected error of each leg [m], None where there is none.

    The displacement at the surface that it expects after a leg is not part of the leg's error, and is left out.
    """
    scenario = Scenario.at_means(mission, recorded_current(mission))
    compensation = scenario.compensation(scenario.transit())
    if compensation is None:
        return None
    found, last_run, memory = [], -1, compensation.begin(1)
    for leg in range(data.n):
        if data.run[leg] != last_run:
            memory, last_run = compensation.begin(1), int(data.run[leg])
        start, reckoned, end = (each[:, leg : leg + 1] for each in (data.start, data.dead_reckoned, data.end))
        t, duration, through = data.t_start[leg : leg + 1], data.under_way[leg : leg + 1], reckoned - start
        planned = PlannedLeg(t, start, through, duration, reckoned, 0.0)
        if isinstance(compensation, DriftFilter):
            expected = compensation.expected(memory, planned)[0] * duration
        else:
            expected = compensation.offset(memory, planned) - compensation.undershoot(memory, planned)
        found.append(np.broadcast_to(expected, (2, 1))[:, 0])
        memory = compensation.update(
            memory,
            CompletedLeg((end - reckoned) / duration, duration, np.zeros((2, 1)), end - reckoned, t, start, through),
        )
    return found
