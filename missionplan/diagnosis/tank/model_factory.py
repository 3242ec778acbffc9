"""From a mission and tank data to the base model of their kind."""

from dataclasses import replace

import numpy as np

from missionplan.datasets.tank import DragSettings, OscillationSettings, TankData, ThrusterSettings
from missionplan.diagnosis.tank.forward import TankForward
from missionplan.diagnosis.tank.free_oscillation import oscillation_forward
from missionplan.diagnosis.tank.propeller import propeller_forward
from missionplan.diagnosis.tank.thruster import thruster_forward
from missionplan.diagnosis.tank.towed_drag import drag_forward
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission


def tank_forward(data: TankData, mission: Mission) -> TankForward:
    """Bind the base model of a kind of tank data, with the constants that the mission's vehicle file has.

    Raises
    ------
    InputError
        When the data hold as many unknowns as numbers, or nothing but zeros.
    """
    forward = _forward(data, mission)
    if not np.any(forward.y):
        words = f"{forward.quantity} is 0 in every row: there is nothing to explain"
        raise InputError([Problem(words, data.settings.file)])
    return forward


def _forward(data: TankData, mission: Mission) -> TankForward:
    settings, vehicle = data.settings, mission.vehicle
    if isinstance(settings, DragSettings):
        plain, faster = (drag_forward(data, settings, vehicle, factor) for factor in (1.0, 2.0))
        return replace(plain, designs=(("the same runs at twice the speeds", faster),))
    if isinstance(settings, OscillationSettings):
        plain, larger = (oscillation_forward(data, settings, vehicle, factor) for factor in (1.0, 3.0))
        return replace(plain, designs=(("a release from three times the displacement", larger),))
    if isinstance(settings, ThrusterSettings):
        return thruster_forward(data, settings)
    return propeller_forward(data, settings)
