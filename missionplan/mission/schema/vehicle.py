"""Vehicle files: hull, sail, mass and buoyancy, anchor, energy. Everything in SI once validated."""

from typing import Annotated, Generic, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.identified import MeasuredAddedMass, MeasuredDrag, Propulsion, StaticThruster
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import FileSection, V, invalid
from missionplan.mission.schema.transition import Manoeuvring, TunnelThrusterSection

_FORM_FACTOR = QuantityParser("", low=0.0, open_low=True)


class HullSection(FileSection, Generic[V]):
    """The egress vehicle's body: a cylinder with hemispherical ends."""

    length: q.PositiveLength[V]
    diameter: q.PositiveLength[V]
    form_factor: Annotated[V | Literal["briggs", "hoerner"], q.or_word(_FORM_FACTOR, "briggs", "hoerner")] = "briggs"
    added_mass: q.Number[V] | None = None
    crossflow_drag: q.PositiveNumber[V] | None = None


class SailSection(FileSection, Generic[V]):
    """The sail, a small airfoil."""

    chord: q.PositiveLength[V]
    span: q.PositiveLength[V]
    thickness: q.PositiveLength[V]


class Front(FileSection, Generic[V]):
    """Machined front of the anchor; `centre` from the anchor's tip."""

    mass: q.Mass[V]
    density: q.Density[V]
    centre: q.Distance[V]


class Tube(FileSection, Generic[V]):
    """Tube between front and back; its length follows from the wet weight."""

    mass_per_length: q.MassPerLength[V]
    density: q.Density[V]


class Back(FileSection, Generic[V]):
    """Machined back of the anchor; `centre_from_back` from the end of the tube."""

    mass: q.Mass[V]
    density: q.Density[V]
    centre_from_back: q.Distance[V]


class TrimSection(FileSection, Generic[V]):
    """Trim ring; its mass and position follow from the wet weight."""

    density: q.Density[V]


class ConstructionSection(FileSection, Generic[V]):
    """Parts and materials of the anchor."""

    front: Front[V]
    tube: Tube[V]
    back: Back[V]
    trim: TrimSection[V]


class Anchor(FileSection, Generic[V]):
    """The anchor, the vehicle's false nose until it is released."""

    diameter: q.PositiveLength[V]
    drag_coefficient: q.PositiveNumber[V] = q.default(0.2)
    overlap_volume: q.Volume[V] = q.default(0.0)
    flooded_mass: q.Mass[V] | None = None
    added_mass: q.Mass[V] | None = None
    construction: ConstructionSection[V] | None = None
    holding_factor: q.PositiveNumber[V] | None = None
    flooding_time: q.Duration[V] | None = None
    premature_flooding: q.Probability = 0.0


class Centre(FileSection, Generic[V]):
    """A centre of the egress vehicle: distance aft of the nose's tip, and below the axis."""

    from_nose: q.Distance[V]
    below_axis: q.Length[V] = q.default(0.0)


class EnergyBudget(FileSection, Generic[V]):
    """Hotel load over all time, propulsion under way, each surfacing, and the energy in the battery."""

    hotel: q.Power[V] = q.default(0.0)
    propulsive_efficiency: q.Efficiency[V] = q.default(0.45)
    surfacing: q.Energy[V] = q.default(0.0)
    capacity: q.Energy[V] | None = None


def _kind(value: object) -> str:
    tunnel = isinstance(value, TunnelThrusterSection) or (isinstance(value, dict) and "diameter" in value)
    return "<tunnel>" if tunnel else "<static>"


class Vehicle(FileSection, Generic[V]):
    """A vehicle file."""

    name: str = ""
    hull: HullSection[V]
    sail: SailSection[V] | None = None
    appendage_factor: q.PositiveNumber[V] = q.default(1.0)
    mass: q.Mass[V] | None = None
    net_buoyancy: q.SignedForce[V] = q.default(0.0)
    centre_of_gravity: Centre[V] | None = None
    centre_of_buoyancy: Centre[V] | None = None
    anchor: Anchor[V] | None = None
    energy: EnergyBudget[V] | None = Field(default=None)
    manoeuvring: Manoeuvring[V] | None = None
    drag: MeasuredDrag[V] | None = None
    added_mass: MeasuredAddedMass[V] | None = None
    propulsion: Propulsion[V] | None = None
    thrusters: tuple[
        Annotated[
            Annotated[TunnelThrusterSection[V], Tag("<tunnel>")] | Annotated[StaticThruster[V], Tag("<static>")],
            Discriminator(_kind),
        ],
        ...,
    ] = ()

    @property
    def centres(self) -> tuple[Centre[V], Centre[V]] | None:
        """Centres of gravity and of buoyancy; None where the file gives none."""
        if self.centre_of_gravity is None or self.centre_of_buoyancy is None:
            return None
        return self.centre_of_gravity, self.centre_of_buoyancy

    @model_validator(mode="after")
    def _both_centres(self) -> Self:
        missing = [key for key in ("centre_of_gravity", "centre_of_buoyancy") if getattr(self, key) is None]
        if len(missing) == 1:
            raise invalid("missing; the centres of gravity and of buoyancy are given together", (missing[0],))
        return self
