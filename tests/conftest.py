"""Settings and fixtures of all tests: single-threaded libraries, fixed Hypothesis examples, a generator with a fixed seed.

Types are checked at run time, in the nightly session also the lengths of axes; see `helpers.type_checks`.
"""

import os
import signal

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as in a background job of a shell; tests of Ctrl-C need the signal
    signal.signal(signal.SIGINT, signal.default_int_handler)
os.environ.update(OMP_NUM_THREADS="1", OMP_WAIT_POLICY="PASSIVE", GOMP_SPINCOUNT="0")

from helpers.type_checks import check_types

check_types(axes=bool(os.environ.get("CHECK_AXES")))

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, settings

cv2.setNumThreads(1)  # torch follows OMP_NUM_THREADS

# Registered here because Hypothesis otherwise picks a profile by whether it detects a CI environment.
_COMMON = {"deadline": None, "database": None, "print_blob": True, "suppress_health_check": [HealthCheck.too_slow]}
settings.register_profile("tests", derandomize=True, max_examples=50, **_COMMON)
settings.register_profile("nightly", derandomize=False, max_examples=1000, **_COMMON)
settings.load_profile("tests")


@pytest.fixture
def rng() -> np.random.Generator:
    """A fresh generator for every test, always with the same seed."""
    return np.random.default_rng(20_240_731)
