"""A vehicle that is diagnosed mission after mission: what was learned is kept, and a change is named."""

import numpy as np
import pytest

from . import __main__ as fleets


@pytest.mark.slow
def test_what_is_learned_is_kept_and_a_change_is_named():
    """A few of the fleets of ``python -m tests.fleets``, whose figures docs/validation/calibration.md gives."""
    found = [fleets.run(seed, changes=changes) for seed in range(3) for changes in (False, True)]
    assert all(fleet.named for fleet in found if fleet.named is not None)
    held = np.concatenate([fleet.held for fleet in found])
    assert held.mean() > 0.8
    assert np.mean([fleet.gains for fleet in found]) > -0.5
