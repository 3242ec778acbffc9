"""Tidal constituents against printed tables and against UTide's own prediction."""

from datetime import UTC, datetime

import numpy as np
import pytest

from missionplan.physics.water import angular_frequencies, constituent_names, nodal_state


def test_periods_are_those_of_the_tables():
    # Doodson & Warburg's table, hours; K1 is the sidereal day.
    periods = {"M2": 12.4206012, "S2": 12.0, "N2": 12.6583482, "K1": 23.9344696, "O1": 25.8193417, "M4": 6.2103006}
    found = 2.0 * np.pi / angular_frequencies(list(periods)) / 3600.0
    np.testing.assert_allclose(found, list(periods.values()), rtol=2e-7)


def test_an_unknown_constituent_is_a_key_error():
    with pytest.raises(KeyError):
        angular_frequencies(["M2", "X9"])
    assert "M2" in constituent_names()


def moment(*day: int) -> float:
    return datetime(*day, tzinfo=UTC).timestamp()


def test_the_node_changes_the_moons_tides_by_schuremans_amounts():
    # The node's longitude N was 0 on 2006-06-19 and 180 degrees on 2015-10-08, within days (lunar standstills).
    # Schureman's table 2: f(M2) = 0.963 and 1.037; f(K1) = 1.113 and 0.882; f(O1) = 1.183 and 0.806; S2 untouched.
    names = ["M2", "K1", "O1", "S2"]
    wide, narrow = (nodal_state(names, when, np.radians(45.0)) for when in (moment(2006, 6, 19), moment(2015, 10, 8)))
    np.testing.assert_allclose(wide.factor, [0.963, 1.113, 1.183, 1.0], atol=0.02)
    np.testing.assert_allclose(narrow.factor, [1.037, 0.882, 0.806, 1.0], atol=0.02)
    np.testing.assert_allclose(wide.angle[[0, 3]], 0.0, atol=0.03)


def test_the_sun_at_greenwich_gives_the_argument_of_s2():
    # S2 has the argument 2·T with T = 15° an hour from midnight: nil at midnight and at noon.
    start = moment(2026, 3, 4)
    arguments = [nodal_state(["S2"], start + hours * 3600.0, 0.7).argument[0] for hours in (0.0, 3.0, 6.0, 12.0)]
    turns = np.mod(np.array(arguments) / (2.0 * np.pi) + 0.25, 1.0) - 0.25
    np.testing.assert_allclose(turns, [0.0, 0.25, 0.5, 0.0], atol=1e-3)


def test_the_argument_advances_with_the_frequency():
    names = ["M2", "N2", "K1", "Q1"]
    start, later = moment(2026, 3, 4), 86400.0
    turned = nodal_state(names, start + later, 0.7).argument - nodal_state(names, start, 0.7).argument
    away = np.angle(np.exp(1j * (turned - angular_frequencies(names) * later)))
    np.testing.assert_allclose(away, 0.0, atol=1e-4)


@pytest.mark.parametrize("latitude", [0.0, -0.01, 0.01])
def test_the_equator_has_finite_corrections(latitude):
    state = nodal_state(["K1", "O1", "M2"], moment(2026, 3, 4), latitude)
    assert np.all(np.isfinite(state.factor))
