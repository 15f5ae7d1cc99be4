"""`lexis-sim doctor`: what this machine can do, and what to change where it cannot."""

import os
import platform
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from lexis.encoder import load_encoder
from lexis.errors import LexisError
from sim.errors import SimError

PACKAGES = ("mujoco", "torch", "open-clip-torch", "opencv-python-headless", "gtsam", "poselib", "numpy", "scipy")


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at."""

    subject: str
    fine: bool
    detail: str
    """What is there, or what to change."""


def examine() -> list[Finding]:
    """Look at the interpreter, cores, packages, off-screen OpenGL and the shipped encoder."""
    findings = [
        Finding("python", True, platform.python_version()),
        Finding("cores", (os.cpu_count() or 1) >= 2, f"{os.cpu_count()}; a run uses two"),
        *map(_package, PACKAGES),
        _attempt("off-screen OpenGL", _render),
        _attempt("encoder mini", _encode),
    ]
    return findings


def versions() -> dict[str, str]:
    """Versions of the packages that shape a result, for result.json."""
    return {"python": platform.python_version()} | {package: version(package) for package in PACKAGES}


def _package(name: str) -> Finding:
    try:
        return Finding(name, True, version(name))
    except PackageNotFoundError:
        return Finding(name, False, f"missing; install it: pip install {name}")


def _attempt(subject: str, attempt: Callable[[], str]) -> Finding:
    try:
        return Finding(subject, True, attempt())
    except (SimError, LexisError) as error:
        return Finding(subject, False, str(error))


def _render() -> str:
    from sim.gl import choose_backend, mujoco, require_rendering

    require_rendering()
    mujoco.GLContext(64, 64).free()
    return choose_backend() or "the system's own"


def _encode() -> str:
    encoder = load_encoder("mini")
    return f"{encoder.encode_image(np.zeros((96, 128, 3), np.uint8)).shape[0]} dimensions"
