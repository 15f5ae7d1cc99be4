"""Settings and fixtures of all tests: single-threaded libraries, fixed Hypothesis examples, a generator with a fixed seed.

Types are checked at run time, by an import hook that is installed before anything else loads the project. beartype's hook
checks types and numbers of axes, and costs about a fifth of the time (27 s instead of 21 s for tests/lexis/sight and graph).
The nightly session uses jaxtyping's hook, which also checks that axes of one name have one length, and takes three times as
long. What pytest has loaded by then, such as our own plugin, has no arrays.
"""

import os
import signal
from pathlib import Path

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as in a background job of a shell; tests of Ctrl-C need the signal
    signal.signal(signal.SIGINT, signal.default_int_handler)
os.environ.update(OMP_NUM_THREADS="1", OMP_WAIT_POLICY="PASSIVE", GOMP_SPINCOUNT="0")

from beartype import BeartypeConf
from beartype.claw import beartype_packages
from jaxtyping import install_import_hook

_CHECKED = ("lexis", "sim", "worlds")
_TOP = Path(__file__).parents[1]


def _with_late_imports() -> tuple[str, ...]:
    """The modules that import some types for mypy only, which beartype cannot look up by their names."""
    paths = (path for name in _CHECKED for path in (_TOP / name).rglob("*.py"))
    late = (path.relative_to(_TOP) for path in paths if "if TYPE_CHECKING:" in path.read_text())
    return tuple(".".join(path.with_suffix("").parts) for path in late)


if os.environ.get("CHECK_AXES"):
    install_import_hook(_CHECKED, "beartype.beartype")
else:  # local variables are annotated for mypy, and need no check
    beartype_packages(_CHECKED, conf=BeartypeConf(claw_is_pep526=False, claw_skip_package_names=_with_late_imports()))

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
