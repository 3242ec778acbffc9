"""How the vehicle lies in the water with its anchor, with the anchor flooded, and without it (Briggs et al., VI.A)."""

from missionplan.arrays import Scalars
from missionplan.mission.schema.phases import MoorPhase
from missionplan.physics.anchor import AnchorDesign, wet_centre
from missionplan.physics.buoyancy import STANDARD_GRAVITY
from missionplan.physics.trim import TrimState, Weight, trim
from missionplan.scenario.anchor_weight import anchor_length
from missionplan.scenario.carried_anchor import overlap_height
from missionplan.scenario.held_vehicle import CENTRES_GIVEN
from missionplan.scenario.scenario import Scenario


def trim_states(means: Scenario, moor: MoorPhase, weight: float, design: AnchorDesign | None) -> tuple[TrimState, ...]:
    """Find the trim of the paper's three configurations.

    Sealed, the anchor's weight and buoyancy cancel, and so do their moments where its ring is in place (Eqs. 16, 17).

    Parameters
    ----------
    means : Scenario
        At the means.
    moor : MoorPhase
    weight : float
        Of the flooded anchor in water [N].
    design : AnchorDesign or None
        Its parts; None where they are not given, and the anchor's wet weight is taken at mid-length.
    """
    known = CENTRES_GIVEN in means.draws
    own = float(means["vehicle.mass"]) * STANDARD_GRAVITY
    middle = 0.5 * float(means["vehicle.hull.length"])

    def centre(key: str, size: float) -> Weight:
        path = f"vehicle.centre_of_{key}"
        places: tuple[Scalars, Scalars] = (middle, 0.0)
        if known:
            places = (means[f"{path}.from_nose"], means[f"{path}.below_axis"])
        return Weight(size, float(places[0]), float(places[1]))

    vehicle = centre("gravity", own)
    buoyancy = centre("buoyancy", own + float(means["vehicle.net_buoyancy"]))
    length = float(anchor_length(means, weight))
    from_tip = wet_centre(design) if design is not None else 0.5 * length
    flooded = Weight(weight, from_tip - (length - overlap_height(means)), 0.0)
    return (
        trim("with the sealed anchor", (vehicle,), buoyancy, centres_known=known),
        trim("with the anchor flooded", (vehicle, flooded), buoyancy, centres_known=known),
        trim("released, without the anchor", (vehicle,), buoyancy, centres_known=known),
    )
