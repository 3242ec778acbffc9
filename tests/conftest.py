"""What every process of a test run needs: its threads, signals, collector of garbage, and the tests' fixtures."""

import gc
import os
import signal

import pytest

# modules and tests stay until the end: the collector of garbage need not look at them over and over
gc.disable()

# before numpy is imported, here and in all that tests start: matrices are small, and threads of one worker only take
# processors from the others
for _threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_threads, "1")

# workers and all programs that tests start keep compiled modules, those of installed packages too
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# tests send Ctrl-C, which a shell has ignored by what it starts in the background: they would wait for ever
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_configure(config: pytest.Config) -> None:
    if hasattr(config, "workerinput") or not config.getoption("tx", None):  # who only hands out tests imports nothing
        config.pluginmanager.import_plugin("tests.fixtures")


def pytest_collection_finish() -> None:
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)  # what tests leave is small
    gc.enable()
