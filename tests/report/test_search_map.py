"""The map of the search areas: hours stand beside their own area, on no line."""

from types import SimpleNamespace

import numpy as np
from matplotlib.figure import Figure

from missionplan.report.simulation.overdue import _name_hours

ANGLE = np.linspace(0.0, 2.0 * np.pi, 60)
LIMITS = np.array([[-3000.0, 7000.0], [-3000.0, 3000.0]])


def area(hours: float, east: float, radius: float) -> SimpleNamespace:
    ring = np.stack((east + radius * np.cos(ANGLE), radius * np.sin(ANGLE)))
    return SimpleNamespace(after="moor", overdue=3600.0 * hours, centre_east=east, points=ring)


def test_hours_stand_beside_their_area_and_on_no_line():
    """The first area lies inside the second, just below its top; the third's top is the map's edge."""
    areas = [area(0.0, 0.0, 300.0), area(1.0, 0.0, 800.0), area(3.0, 500.0, 1000.0), area(6.0, 3900.0, 2950.0)]
    axes = Figure().add_subplot()
    _name_hours(axes, areas, LIMITS)
    assert sorted(text.get_text().replace("\u00a0", " ") for text in axes.texts) == ["+1 h", "+3 h", "+6 h"]
    for text, own in zip(axes.texts, areas[1:], strict=True):
        place = 1000.0 * np.array(text.get_position())[:, None]
        to_lines = [np.hypot(*(each.points - place)).min() for each in areas]
        assert min(to_lines) > 200.0
        assert np.hypot(*(own.points - place)).min() < 500.0
        assert np.all((LIMITS[:, :1] < place) & (place < LIMITS[:, 1:]))
