"""What all tests share."""

from hypothesis import HealthCheck, settings

# no test is timed: a loaded machine is slow
settings.register_profile("untimed", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("untimed")
