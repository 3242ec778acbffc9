"""Vehicle files: hull, sail, mass and buoyancy, anchor, energy. Everything in SI once validated."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.identified import MeasuredAddedMass, MeasuredDrag, Propulsion, Thruster
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import FileSection, invalid
from missionplan.mission.schema.transition import Manoeuvring
from missionplan.montecarlo.distributions import Quantity

_FORM_FACTOR = QuantityParser("", low=0.0, open_low=True)


class HullSection(FileSection):
    """The egress vehicle's body: a cylinder with hemispherical ends."""

    length: q.PositiveLength
    diameter: q.PositiveLength
    form_factor: Annotated[Quantity | Literal["briggs", "hoerner"], q.or_word(_FORM_FACTOR, "briggs", "hoerner")] = (
        "briggs"
    )
    added_mass: q.Number | None = None
    crossflow_drag: q.PositiveNumber | None = None


class SailSection(FileSection):
    """The sail, a small airfoil."""

    chord: q.PositiveLength
    span: q.PositiveLength
    thickness: q.PositiveLength


class Front(FileSection):
    """Machined front of the anchor; `centre` from the anchor's tip."""

    mass: q.Mass
    density: q.Density
    centre: q.Distance


class Tube(FileSection):
    """Tube between front and back; its length follows from the wet weight."""

    mass_per_length: q.MassPerLength
    density: q.Density


class Back(FileSection):
    """Machined back of the anchor; `centre_from_back` from the end of the tube."""

    mass: q.Mass
    density: q.Density
    centre_from_back: q.Distance


class TrimSection(FileSection):
    """Trim ring; its mass and position follow from the wet weight."""

    density: q.Density


class ConstructionSection(FileSection):
    """Parts and materials of the anchor."""

    front: Front
    tube: Tube
    back: Back
    trim: TrimSection


class Anchor(FileSection):
    """The anchor, the vehicle's false nose until it is released."""

    diameter: q.PositiveLength
    drag_coefficient: q.PositiveNumber = 0.2
    overlap_volume: q.Volume = 0.0
    flooded_mass: q.Mass | None = None
    added_mass: q.Mass | None = None
    construction: ConstructionSection | None = None
    holding_factor: q.PositiveNumber | None = None
    flooding_time: q.Duration | None = None
    premature_flooding: q.Probability = 0.0


class Centre(FileSection):
    """A centre of the egress vehicle: distance aft of the nose's tip, and below the axis."""

    from_nose: q.Distance
    below_axis: q.Length = 0.0


class EnergyBudget(FileSection):
    """Hotel load over all time, propulsion under way, each surfacing, and the energy in the battery."""

    hotel: q.Power = 0.0
    propulsive_efficiency: q.Efficiency = 0.45
    surfacing: q.Energy = 0.0
    capacity: q.Energy | None = None


class Vehicle(FileSection):
    """A vehicle file."""

    name: str = ""
    hull: HullSection
    sail: SailSection | None = None
    appendage_factor: q.PositiveNumber = 1.0
    mass: q.Mass | None = None
    net_buoyancy: q.SignedForce = 0.0
    centre_of_gravity: Centre | None = None
    centre_of_buoyancy: Centre | None = None
    anchor: Anchor | None = None
    energy: EnergyBudget | None = Field(default=None)
    manoeuvring: Manoeuvring | None = None
    drag: MeasuredDrag | None = None
    added_mass: MeasuredAddedMass | None = None
    propulsion: Propulsion | None = None
    thrusters: tuple[Thruster, ...] = ()

    @model_validator(mode="after")
    def _both_centres(self) -> "Vehicle":
        missing = [key for key in ("centre_of_gravity", "centre_of_buoyancy") if getattr(self, key) is None]
        if len(missing) == 1:
            raise invalid("missing; the centres of gravity and of buoyancy are given together", (missing[0],))
        return self
