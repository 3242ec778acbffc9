"""Static thrust against its command."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from missionplan.physics.tunnel_thruster import bollard_pull


def test_ahead_and_astern_have_their_own_constants():
    np.testing.assert_allclose(bollard_pull(np.array([-2.0, 0.0, 2.0]), 9.423, 6.551), [-26.204, 0.0, 37.692])


def test_nothing_inside_the_deadband():
    np.testing.assert_array_equal(bollard_pull(np.array([-0.5, 0.0, 0.5]), 9.0, 6.0, 0.5), 0.0)


@given(command=st.floats(-10.0, 10.0), deadband=st.floats(0.0, 2.0))
def test_thrust_goes_with_the_command_and_grows_with_it(command, deadband):
    thrust = bollard_pull(command, 9.0, 6.0, deadband)
    assert thrust * command >= 0.0
    assert bollard_pull(command + 0.1, 9.0, 6.0, deadband) >= thrust
