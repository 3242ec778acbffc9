"""Type of the moments in mission files and data sets: aware, in UTC."""

from datetime import datetime
from typing import Annotated

from missionplan.errors import shown
from missionplan.mission.schema.section import ReadBy, invalid
from missionplan.moments import EXAMPLE, moment_of


def _read(value: object) -> datetime:
    try:
        return moment_of(value)
    except (ValueError, OverflowError) as error:
        words = str(error) if "expected" in str(error) else f"{error}; expected a date and time such as {EXAMPLE}"
        raise invalid(f"given {shown(value)}: {words}") from None


Moment = Annotated[datetime, ReadBy(_read)]
"""Read by `missionplan.moments.moment_of`."""
