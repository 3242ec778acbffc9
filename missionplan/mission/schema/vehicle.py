"""Vehicle files: hull, sail, mass and buoyancy, anchor, energy. Everything in SI once validated.

How often the vehicle's parts fail: hazards per hour, kilometre, surfacing, dive, release and wake-up.
"""

from typing import Annotated, Generic, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator
from typing_extensions import Doc

from missionplan.errors import LocalProblem
from missionplan.mission.schema import FileSection, ReadBy, V, VehicleSchema, all_invalid, invalid
from missionplan.mission.schema import quantity_parser as q
from missionplan.mission.schema.manoeuvring import (
    Manoeuvring,
    MeasuredAddedMass,
    MeasuredDrag,
    Propulsion,
    StaticThruster,
    TunnelThrusterSection,
)
from missionplan.mission.schema.quantity_parser import Limit, QuantityParser
from missionplan.mission.schema.site import LeewaySection

Per = Literal["hour", "km", "surfacing", "dive", "release", "wake-up"]
Leaves = Literal["adrift", "moored", "sunk", "lost", "beacon"]
_Count = Annotated[float, q.fixed("")]
_Exposure = Annotated[float, q.fixed("", open_low=True)]
_HourlyRate = Annotated[V, ReadBy(QuantityParser("1/s", low=0.0))]
_RateByDistance = Annotated[V, ReadBy(QuantityParser("1/m", low=0.0))]
_Chance = Annotated[V, ReadBy(QuantityParser("", low=0.0, high=1.0))]
_Lifetime = Annotated[V, ReadBy(QuantityParser("s", low=0.0, open_low=True))]
_HASH = Field(examples=[["0123456789abcdef"]])


class _Hazard(FileSection, Generic[V]):
    """What all hazards have: counts, the shape of a Weibull law, what a failure leaves, where the number is from.

    `failures` in an `exposure` (of hours, kilometres or events) give a gamma distribution of the rate, of shape
    failures + ½: Jeffreys' prior. `source` is the paper, the log or the data sheet.
    """

    failures: Annotated[_Count | None, Doc("failures seen"), Limit((0.0, 1e6), (0.0, 1000.0), "counts")] = None
    exposure: Annotated[
        _Exposure | None, Doc("hours, kilometres or events in which they were"), Limit((0.0, 1e9), (0.0, 1e7), "counts")
    ] = None
    shape: Annotated[
        q.PositiveNumber[V] | None,
        Doc("shape of the Weibull law; 1: as likely at any age"),
        Limit((0.05, 20.0), (0.3, 5.0), "0.5 for early failures, 3 for wear"),
    ] = None
    leaves: Annotated[Leaves | None, Doc("state in which a failure leaves the vehicle")] = None
    source: Annotated[str, Doc("where the rate is from"), Field(examples=["log book of 2025"])] = ""
    learned_from: Annotated[tuple[str, ...], Doc("hashes of the rows of a fleet's log that are counted"), _HASH] = ()

    @model_validator(mode="after")
    def _one_law(self) -> Self:
        pairs = {"rate": ("rate",), "counts": ("failures", "exposure"), "Weibull": ("shape", "scale")}
        laws = {law: [key for key in keys if getattr(self, key) is not None] for law, keys in pairs.items()}
        problems = [
            LocalProblem((key,), "missing; failures and exposure, shape and scale are given together")
            for law, keys in pairs.items()
            for key in keys
            if laws[law] and key not in laws[law]
        ]
        if not problems and sum(bool(keys) for keys in laws.values()) != 1:
            problems = [LocalProblem((), "expected one of rate, {failures, exposure} and {shape, scale}")]
        if problems:
            raise all_invalid(problems)
        return self


class HourlyHazard(_Hazard[V], Generic[V]):
    """A hazard of all time since the mission's start."""

    per: Annotated[Literal["hour"], Doc("what the rate counts")]
    rate: Annotated[
        _HourlyRate[V] | None, Doc("failures an hour"), Limit((0.0, 1.0), (0.0, 1e-5), "gliders: 1e-4 to 1e-3 1/h")
    ] = None
    scale: Annotated[
        _Lifetime[V] | None, Doc("age by which 63 % have failed"), Limit((1.0, 1e10), (3600.0, 1e9), "hours to years")
    ] = None


class DistanceHazard(_Hazard[V], Generic[V]):
    """A hazard of the distance through the water."""

    per: Annotated[Literal["km"], Doc("what the rate counts")]
    rate: Annotated[
        _RateByDistance[V] | None, Doc("failures a kilometre"), Limit((0.0, 1.0), (0.0, 1e-3), "below one a kilometre")
    ] = None
    scale: Annotated[
        q.PositiveLength[V] | None,
        Doc("distance by which 63 % have failed"),
        Limit((1.0, 1e10), (1000.0, 1e8), "kilometres to thousands of them"),
    ] = None


class EventHazard(_Hazard[V], Generic[V]):
    """A hazard of each surfacing, dive, release of an anchor or wake-up after a hold."""

    per: Annotated[Literal["surfacing", "dive", "release", "wake-up"], Doc("what the rate counts")]
    rate: Annotated[
        _Chance[V] | None, Doc("probability of a failure each time"), Limit((0.0, 1.0), (0.0, 0.2), "a probability")
    ] = None
    scale: Annotated[
        q.PositiveNumber[V] | None, Doc("events by which 63 % have failed"), Limit((0.1, 1e9), (1.0, 1e6), "events")
    ] = None


def hazard_tag(value: object) -> str:
    """Tell hazards of time, of distance and of events apart."""
    per = value.get("per") if isinstance(value, dict) else getattr(value, "per", None)
    return {"hour": "<hour>", "km": "<km>"}.get(str(per), "<event>")


Hazard = HourlyHazard[V] | DistanceHazard[V] | EventHazard[V]


_FORM_FACTOR = QuantityParser("", low=0.0, open_low=True)


class HullSection(FileSection, Generic[V]):
    """The egress vehicle's body: a cylinder with hemispherical ends."""

    length: Annotated[q.PositiveLength[V], Doc("length over all without the anchor"), q.LENGTH]
    diameter: Annotated[q.PositiveLength[V], Doc("largest diameter"), q.DIAMETER]
    form_factor: Annotated[
        V | Literal["briggs", "hoerner"],
        q.or_word(_FORM_FACTOR, "briggs", "hoerner"),
        Doc("constant of the form drag, or whose it is"),
        Limit((1e-3, 100.0), (0.2, 5.0), "Hoerner 1, Briggs et al. 2.64"),
    ] = "briggs"
    added_mass: Annotated[
        q.Number[V] | None,
        Doc("added mass in surge over the displaced mass"),
        Limit((0.0, 10.0), (0.0, 1.0), "Lamb: 0.5 for a sphere, less for what is longer"),
    ] = None
    crossflow_drag: Annotated[
        q.PositiveNumber[V] | None,
        Doc("drag coefficient across the hull on length times diameter, fins included"),
        Limit((0.05, 10.0), (0.3, 2.0), "Hoerner: 0.3 beyond the drag crisis, 1.2 below"),
    ] = None


class SailSection(FileSection, Generic[V]):
    """The sail, a small airfoil."""

    chord: Annotated[q.PositiveLength[V], Doc("chord of the sail"), q.FIN]
    span: Annotated[q.PositiveLength[V], Doc("span of the sail"), q.FIN]
    thickness: Annotated[
        q.PositiveLength[V],
        Doc("thickness of the sail"),
        Limit((1e-4, 10.0), (1e-3, 1.0), "a sail is thinner than its chord"),
    ]


class Front(FileSection, Generic[V]):
    """Machined front of the anchor."""

    mass: Annotated[q.Mass[V], Doc("mass of the front"), q.PART_MASS]
    density: Annotated[q.Density[V], Doc("density of its material"), q.DENSITY]
    centre: Annotated[q.Distance[V], Doc("distance of its centre from the anchor's tip")]


class Tube(FileSection, Generic[V]):
    """Tube between front and back; its length follows from the wet weight."""

    mass_per_length: Annotated[q.MassPerLength[V], Doc("mass of a metre of tube")]
    density: Annotated[q.Density[V], Doc("density of the tube's material"), q.DENSITY]


class Back(FileSection, Generic[V]):
    """Machined back of the anchor."""

    mass: Annotated[q.Mass[V], Doc("mass of the back"), q.PART_MASS]
    density: Annotated[q.Density[V], Doc("density of its material"), q.DENSITY]
    centre_from_back: Annotated[q.Distance[V], Doc("distance of its centre from the end of the tube")]


class TrimSection(FileSection, Generic[V]):
    """Trim ring; its mass and position follow from the wet weight."""

    density: Annotated[
        q.Density[V],
        Doc("density of the trim ring"),
        Limit((1100.0, 23_000.0), (2000.0, 20_000.0), "a ring lighter than water adds no wet weight; brass 8500"),
    ]


class ConstructionSection(FileSection, Generic[V]):
    """Parts and materials of the anchor."""

    front: Annotated[Front[V], Doc("solid front with the tip")]
    tube: Annotated[Tube[V], Doc("tube whose length is chosen")]
    back: Annotated[Back[V], Doc("end of the tube")]
    trim: Annotated[TrimSection[V], Doc("ring that trims the centre of gravity")]


class Anchor(FileSection, Generic[V]):
    """The anchor, the vehicle's false nose until it is released."""

    diameter: Annotated[q.PositiveLength[V], Doc("diameter of the anchor"), q.DIAMETER]
    drag_coefficient: Annotated[
        q.PositiveNumber[V],
        Doc("drag coefficient on the frontal area"),
        Limit((1e-3, 20.0), (0.05, 2.0), "Hoerner: 0.2 rounded, 1.2 flat"),
    ] = q.default(0.2)
    overlap_volume: Annotated[
        q.Volume[V],
        Doc("volume of the vehicle's nose inside the anchor"),
        Limit((0.0, 10.0), (0.0, 0.5), "a part of the anchor's own volume"),
    ] = q.default(0.0)
    flooded_mass: Annotated[
        q.Mass[V] | None,
        Doc("mass with the water inside"),
        Limit((1e-3, 20_000.0), (0.05, 2000.0), "Briggs et al.: 2.8 kg"),
    ] = None
    added_mass: Annotated[
        q.Mass[V] | None,
        Doc("added mass of the sinking anchor"),
        Limit((1e-6, 20_000.0), (1e-3, 2000.0), "less than the water it displaces"),
    ] = None
    construction: Annotated[
        ConstructionSection[V] | None, Doc("parts of which the anchor is made, for its length and trim")
    ] = None
    holding_factor: Annotated[
        q.PositiveNumber[V] | None,
        Doc("force that holds the anchor over that with which it presses on the seafloor"),
        Limit(
            (1e-3, 100.0),
            (0.1, 1.5),
            "DNV-RP-F109: 0.2 on clay, 0.6 on sand; one that digs in holds more than its weight",
        ),
    ] = None
    flooding_time: Annotated[
        q.Duration[V] | None,
        Doc("time from the separation until the anchor is full of water"),
        Limit((0.0, q.HOUR), (0.0, 120.0), "1 L enters through a hole of 8 mm in 20 s"),
    ] = None
    premature_flooding: Annotated[
        q.Probability, Doc("probability that it floods before its release and sinks the vehicle nose first")
    ] = 0.0


class Centre(FileSection, Generic[V]):
    """A centre of the egress vehicle."""

    from_nose: Annotated[q.Distance[V], Doc("distance aft of the nose's tip"), q.CENTRE]
    below_axis: Annotated[q.Length[V], Doc("distance below the hull's axis"), q.OFF_AXIS] = q.default(0.0)


class EnergyBudget(FileSection, Generic[V]):
    """Hotel load over all time, propulsion under way, each surfacing, and the energy in the battery."""

    hotel: Annotated[
        q.Power[V],
        Doc("power at all times besides propulsion"),
        Limit((0.0, 100_000.0), (0.0, 3000.0), "AUVs draw 1 W to 1 kW besides propulsion"),
    ] = q.default(0.0)
    propulsive_efficiency: Annotated[
        q.Efficiency[V],
        Doc("thrust times speed over the electrical power of propulsion"),
        Limit((1e-3, 1.0), (0.05, 0.9), "small propellers reach 0.3 to 0.7"),
    ] = q.default(0.45)
    surfacing: Annotated[
        q.Energy[V],
        Doc("energy of a surfacing besides its time"),
        Limit((0.0, 1e5), (0.0, 100.0), "a fix and a message take a fraction of a W h", unit="W*h"),
    ] = q.default(0.0)
    capacity: Annotated[
        q.Energy[V] | None,
        Doc("energy in the battery"),
        Limit(
            (0.0, 1e8), (1.0, 2e6), "batteries of AUVs hold 50 W h to 100 kW h, the largest 18 MW h of fuel", unit="W*h"
        ),
    ] = None


def _kind(value: object) -> str:
    tunnel = isinstance(value, TunnelThrusterSection) or (isinstance(value, dict) and "diameter" in value)
    return "<tunnel>" if tunnel else "<static>"


class Vehicle(FileSection, Generic[V]):
    """A vehicle file."""

    file_schema: VehicleSchema = Field(default="missionplan/vehicle/1", alias="schema")
    name: Annotated[str, Doc("name of the vehicle"), Field(examples=["REMUS 100"])] = ""
    hull: Annotated[HullSection[V], Doc("shape of the hull")]
    sail: Annotated[SailSection[V] | None, Doc("fin whose drag adds to that of the hull")] = None
    appendage_factor: Annotated[
        q.PositiveNumber[V],
        Doc("drag with all appendages over that of hull and sail"),
        Limit((0.1, 20.0), (1.0, 3.0), "Briggs et al., Eq. 13: 1.25"),
    ] = q.default(1.0)
    mass: Annotated[q.Mass[V] | None, Doc("mass in air without the anchor"), q.MASS] = None
    net_buoyancy: Annotated[q.SignedForce[V], Doc("buoyancy less weight without the anchor")] = q.default(0.0)
    centre_of_gravity: Annotated[
        Centre[V] | None, Doc("centre of mass without the anchor; with that of buoyancy the vehicle pitches over")
    ] = None
    centre_of_buoyancy: Annotated[Centre[V] | None, Doc("centre of the displaced water")] = None
    anchor: Annotated[Anchor[V] | None, Doc("false nose that becomes the anchor")] = None
    anchors: Annotated[
        int, Field(ge=1, le=100), Doc("anchors aboard at the start, one for each mooring; those left stay on the nose")
    ] = 1
    energy: Annotated[EnergyBudget[V] | None, Doc("energy that is drawn and carried")] = Field(default=None)
    leeway: Annotated[LeewaySection[V] | None, Doc("how the wind drives the vehicle at the surface")] = None
    manoeuvring: Annotated[
        Manoeuvring[V] | None, Doc("derivatives and controllers of the vertical plane, for a transition")
    ] = None
    drag: Annotated[MeasuredDrag[V] | None, Doc("measured drag, in place of that of the formulas")] = None
    added_mass: Annotated[MeasuredAddedMass[V] | None, Doc("measured added masses, in place of Lamb's")] = None
    propulsion: Annotated[Propulsion[V] | None, Doc("propeller and motor, from which speed and power follow")] = None
    reliability: Annotated[
        tuple[
            Annotated[
                Annotated[HourlyHazard[V], Tag("<hour>")]
                | Annotated[DistanceHazard[V], Tag("<km>")]
                | Annotated[EventHazard[V], Tag("<event>")],
                Discriminator(hazard_tag),
            ],
            ...,
        ],
        Doc("rates at which equipment fails"),
    ] = ()
    thrusters: Annotated[
        tuple[
            Annotated[
                Annotated[TunnelThrusterSection[V], Tag("<tunnel>")] | Annotated[StaticThruster[V], Tag("<static>")],
                Discriminator(_kind),
            ],
            ...,
        ],
        Doc("tunnel or static thrusters"),
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
