"""How often the vehicle's parts fail: hazards per hour, kilometre, surfacing, dive, release and wake-up."""

from typing import Annotated, Generic, Literal, Self

from pydantic import model_validator
from typing_extensions import Doc

from missionplan.errors import LocalProblem
from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.limits import Limit
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import FileSection, ReadBy, V, all_invalid

Per = Literal["hour", "km", "surfacing", "dive", "release", "wake-up"]
Leaves = Literal["adrift", "moored", "sunk", "lost", "beacon"]
_Count = Annotated[float, ReadBy(QuantityParser("", low=0.0, fixed=True))]
_Exposure = Annotated[float, ReadBy(QuantityParser("", low=0.0, open_low=True, fixed=True))]
_HourlyRate = Annotated[V, ReadBy(QuantityParser("1/s", low=0.0))]
_RateByDistance = Annotated[V, ReadBy(QuantityParser("1/m", low=0.0))]
_Chance = Annotated[V, ReadBy(QuantityParser("", low=0.0, high=1.0))]
_Lifetime = Annotated[V, ReadBy(QuantityParser("s", low=0.0, open_low=True))]


class _Hazard(FileSection, Generic[V]):
    """What all hazards have: counts, the shape of a Weibull law, what a failure leaves, where the number is from.

    `failures` in an `exposure` (of hours, kilometres or events) give a gamma distribution of the rate, of shape
    failures + ½: Jeffreys' prior. `source` is the paper, the log or the data sheet; `learned_from` the hashes of
    the rows of a fleet's log that `history` has counted.
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
    leaves: Leaves | None = None
    source: str = ""
    learned_from: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _one_law(self) -> Self:
        pairs = {"rate": ("rate",), "counts": ("failures", "exposure"), "Weibull": ("shape", "scale")}
        given = {law: [key for key in keys if getattr(self, key) is not None] for law, keys in pairs.items()}
        problems = [
            LocalProblem((key,), "missing; failures and exposure, shape and scale are given together")
            for law, keys in pairs.items()
            for key in keys
            if given[law] and key not in given[law]
        ]
        if not problems and sum(bool(keys) for keys in given.values()) != 1:
            problems = [LocalProblem((), "expected one of rate, {failures, exposure} and {shape, scale}")]
        if problems:
            raise all_invalid(problems)
        return self


class HourlyHazard(_Hazard[V], Generic[V]):
    """A hazard of all time since the mission's start."""

    per: Literal["hour"]
    rate: Annotated[
        _HourlyRate[V] | None, Doc("failures an hour"), Limit((0.0, 1.0), (0.0, 1e-5), "gliders: 1e-4 to 1e-3 1/h")
    ] = None
    scale: Annotated[
        _Lifetime[V] | None, Doc("age by which 63 % have failed"), Limit((1.0, 1e10), (3600.0, 1e9), "hours to years")
    ] = None


class DistanceHazard(_Hazard[V], Generic[V]):
    """A hazard of the distance through the water."""

    per: Literal["km"]
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

    per: Literal["surfacing", "dive", "release", "wake-up"]
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
