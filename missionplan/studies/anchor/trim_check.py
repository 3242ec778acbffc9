"""How the vehicle lies in the water with its anchor, with the anchor flooded, and without it (Briggs et al., VI.A)."""

from missionplan.arrays import Scalars
from missionplan.mission.schema.vehicle import Centre
from missionplan.physics.anchor import AnchorDesign, wet_centre
from missionplan.physics.trim import TrimState, Weight, trim
from missionplan.physics.water import STANDARD_GRAVITY
from missionplan.scenario.anchors import anchor_length, overlap_height
from missionplan.scenario.scenario import Scenario


def trim_states(means: Scenario, weight: float, design: AnchorDesign | None) -> tuple[TrimState, ...]:
    """Find the trim of the paper's three configurations.

    Sealed, the anchor's weight and buoyancy cancel, and so do their moments where its ring is in place (Eqs. 16, 17).

    Parameters
    ----------
    means : Scenario
        At the means.
    weight : float
        Of the flooded anchor in water [N].
    design : AnchorDesign or None
        Its parts; None where they are not given, and the anchor's wet weight is taken at mid-length.
    """
    hull = means.mooring.vehicle
    known, own = hull.centres is not None, float(means.mooring.mass) * STANDARD_GRAVITY
    middle = Centre[Scalars].model_construct(from_nose=0.5 * float(hull.hull.length), below_axis=0.0)
    gravity, displaced = hull.centres or (middle, middle)
    vehicle = Weight(own, float(gravity.from_nose), float(gravity.below_axis))
    carried = own + float(hull.net_buoyancy)
    buoyancy = Weight(carried, float(displaced.from_nose), float(displaced.below_axis))
    length = float(anchor_length(means, weight))
    from_tip = wet_centre(design) if design is not None else 0.5 * length
    flooded = Weight(weight, from_tip - (length - overlap_height(means)), 0.0)
    return (
        trim("with the sealed anchor", (vehicle,), buoyancy, centres_known=known),
        trim("with the anchor flooded", (vehicle, flooded), buoyancy, centres_known=known),
        trim("released, without the anchor", (vehicle,), buoyancy, centres_known=known),
    )
