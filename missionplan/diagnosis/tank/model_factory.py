"""From a mission and tank data to the base model of their kind."""

from dataclasses import replace

from missionplan.datasets.tank import DragSettings, OscillationSettings, TankData, ThrusterSettings
from missionplan.diagnosis.tank.forward import TankForward
from missionplan.diagnosis.tank.free_oscillation import oscillation_forward
from missionplan.diagnosis.tank.propeller import propeller_forward
from missionplan.diagnosis.tank.thruster import thruster_forward
from missionplan.diagnosis.tank.towed_drag import drag_forward
from missionplan.mission import Mission


def tank_forward(data: TankData, mission: Mission) -> TankForward:
    """Bind the base model of a kind of tank data, with the constants that the mission's vehicle file has.

    Raises
    ------
    InputError
        When the data hold as many unknowns as numbers.
    """
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
