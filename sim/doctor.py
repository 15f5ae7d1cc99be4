"""`lexis-sim doctor`: what this machine can do, and what to change where it cannot."""

import os
import platform
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from lexis.errors import LexisError
from sim.errors import GraphicsError, SimError

_GIB = 1 << 30
NEEDED_BYTES = 2 * _GIB
"""Of a rendered run: at most 1.2 GB apart from torch, and torch."""
_MEMINFO = Path("/proc/meminfo")
_CGROUP_MAX, _CGROUP_USED = Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory.current")
_SCENE = '<mujoco><worldbody><light pos="0 0 3"/><geom size=".3 .3 .3" type="box"/></worldbody></mujoco>'
PACKAGES = ("mujoco", "torch", "open-clip-torch", "opencv-python-headless", "gtsam", "poselib", "numpy", "scipy")


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at."""

    subject: str
    fine: bool
    detail: str
    """What is there, or what to change."""


def examine() -> list[Finding]:
    """Look at the interpreter, cores, memory, packages, off-screen OpenGL and the shipped encoder."""
    findings = [
        Finding("python", True, platform.python_version()),
        Finding("cores", (os.cpu_count() or 1) >= 2, f"{os.cpu_count()}; a run uses two"),
        _memory(available_bytes()),
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


def available_bytes() -> int | None:
    """What a new process may use before it is killed: the machine's free memory, or the container's; None: unknown."""
    found = []
    if _MEMINFO.is_file():
        rows = (line.split() for line in _MEMINFO.read_text().splitlines())
        found += [1024 * int(row[1]) for row in rows if row[0] == "MemAvailable:"]
    if (
        all(path.is_file() for path in (_CGROUP_MAX, _CGROUP_USED))
        and (limit := _CGROUP_MAX.read_text().strip()).isdecimal()
    ):
        found.append(int(limit) - int(_CGROUP_USED.read_text()))
    return min(found, default=None)


def _memory(available: int | None) -> Finding:
    if available is None:
        return Finding("memory", True, "unknown on this system")
    fine, detail = available >= NEEDED_BYTES, f"{available / _GIB:.1f} GiB free"
    needed = f"; a run needs {NEEDED_BYTES / _GIB:.1f} GiB: free some, or give the container more"
    return Finding("memory", fine, detail if fine else detail + needed)


def _render() -> str:
    from sim.gl import choose_backend, graphics_errors, mujoco, require_rendering

    require_rendering()
    model = mujoco.MjModel.from_xml_string(_SCENE)
    with graphics_errors("a first picture"), mujoco.Renderer(model, 48, 64) as renderer:
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        renderer.update_scene(data)
        if renderer.render().std() == 0.0:
            raise GraphicsError(
                f"{choose_backend()} draws nothing but one colour; update its driver or try another MUJOCO_GL"
            )
    return f"{choose_backend() or 'the own of this system'} draws"


def _encode() -> str:
    from lexis.encoder import load_encoder  # torch takes seconds, and `versions` does without

    encoder = load_encoder("mini")
    return f"{encoder.encode_image(np.zeros((96, 128, 3), np.uint8)).shape[0]} dimensions"
