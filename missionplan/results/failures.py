"""Ways in which a trial fails: the words that summaries, tables and pages write them with."""

from enum import StrEnum

from missionplan.phases.place.place import Cause


class Failure(StrEnum):
    """Why a phase ends a trial."""

    NOT_ARRIVED = "not arrived"
    OUTRUN = "current faster than the vehicle"
    LEFT_RECORD = "left the record of the current"
    AGROUND = "aground"
    ON_LAND = "on-land"
    KEEP_OUT = "keep-out"
    UNCHARTED = "left the grid of depths"
    EQUIPMENT = "equipment"
    OUT_OF_ENERGY = "out of energy"
    TOO_SHALLOW = "line and vehicle longer than the water is deep"
    FLOODED_EARLY = "anchor flooded before its release"
    TOO_LIGHT = "anchor too light to sink the vehicle"
    LINE_PARTED = "line parted"
    NOT_DOWN = "anchor did not reach the seafloor"
    OUTSIDE = "anchor outside the radius"
    STRUCK = "struck the seafloor"
    DRAGGED = "anchor dragged"
    GROUNDED = "grounded in the hold"
    NOT_SURFACED = "did not surface"
    NOT_HOVERING = "did not come to hover"


MET = {
    Cause.AGROUND: Failure.AGROUND,
    Cause.ON_LAND: Failure.ON_LAND,
    Cause.KEEP_OUT: Failure.KEEP_OUT,
    Cause.UNCHARTED: Failure.UNCHARTED,
}
"""Failures by what a trial has met."""
LIMITS = (
    Failure.EQUIPMENT,
    Failure.LEFT_RECORD,
    Failure.OUTRUN,
    *MET.values(),
    Failure.TOO_SHALLOW,
    Failure.TOO_LIGHT,
)
"""Failures where the world sets a limit: reported where some trial met it."""
