"""`lexis-sim doctor`: checks whether this machine can run LEXIS-sim, and says what to change if it cannot."""

import os
import platform
import signal
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from threadpoolctl import threadpool_info

from sim.processes import usable_cores

_GIB = 1 << 30
NEEDED_BYTES = 2 * _GIB
"""Memory that a run with rendered images needs [bytes]: at most 1.2 GB without torch, plus torch itself."""
_MEMINFO = Path("/proc/meminfo")
_CGROUP_MAX, _CGROUP_USED, _CGROUP_STAT = (Path("/sys/fs/cgroup", f"memory.{name}") for name in ("max", "current", "stat"))
PACKAGES = (
    *("mujoco", "torch", "torchvision", "open-clip-torch", "timm", "opencv-python-headless", "gtsam", "poselib"),
    *("numpy", "scipy", "shapely"),
)
PROBES = "sim.doctor_probes"
PROBE_TIMEOUT_S = 300.0
_OTHERS = ("cv2", "opencv", "scipy")
"""Prefixes of the folders of packages that contain their own copy of OpenBLAS. numpy does not use these copies."""
_PACKAGES = "site-packages"
_BROKEN = "update the graphics driver and torch, or try another MUJOCO_GL (egl, osmesa)"
_BROKEN_OPENCV = "install opencv-python-headless again, without any other OpenCV"


@dataclass(frozen=True)
class Diagnosis:
    """The result of one check of the machine."""

    subject: str
    fine: bool
    detail: str
    """Text that reports the finding if the check passed, and otherwise says what to change."""


def examine() -> list[Diagnosis]:
    """Check interpreter, cores, memory, packages, linear algebra, off-screen OpenGL, key points and the shipped encoder."""
    drawing = probe("off-screen OpenGL", "draw")
    return [
        Diagnosis("python", True, f"{platform.python_version()}, {platform.machine()}"),
        _cores(usable_cores()),
        _memory(available_bytes()),
        *map(_package, PACKAGES),
        Diagnosis("OpenBLAS kernels", True, _openblas_kernels() or "not found; numpy uses another linear algebra library"),
        drawing,
        probe("AKAZE key points", "detect", advice=_BROKEN_OPENCV),
        probe("encoder mini", *(["draw"] if drawing.fine else []), "encode"),  # in one process, as in a run
    ]


def versions() -> dict[str, str | None]:
    """Return what can change the last digits of a result: versions of packages, processor, BLAS kernels and GL back end.

    result.json records these entries. None means that a package is not installed under this name, that numpy does not use
    OpenBLAS, or that `MUJOCO_GL` is not set.
    """
    return {
        "python": platform.python_version(),
        **_package_versions(),
        "machine": platform.machine(),
        "openblas_kernels": _openblas_kernels(),
        "gl": os.environ.get("MUJOCO_GL"),
    }


@cache
def _package_versions() -> dict[str, str | None]:
    """Return the version of each package, or None if no distribution has its name.

    The result is cached: versions do not change while the process runs.
    """
    return {package: _version(package) for package in PACKAGES}


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _openblas_kernels() -> str | None:
    """Return the processor family for which numpy's OpenBLAS has chosen its kernels, such as "Haswell".

    The result is None if numpy uses another library.
    """
    for library in threadpool_info():
        folders = _within_packages(Path(library["filepath"]).parent.parts)
        if library["internal_api"] == "openblas" and not any(folder.startswith(_OTHERS) for folder in folders):
            return str(library["architecture"])
    return None


def _within_packages(folders: tuple[str, ...]) -> tuple[str, ...]:
    """Return the folders below the last site-packages; () for a library that lies elsewhere."""
    return folders[len(folders) - folders[::-1].index(_PACKAGES) :] if _PACKAGES in folders else ()


def _package(name: str) -> Diagnosis:
    try:
        return Diagnosis(name, True, version(name))
    except PackageNotFoundError:
        return Diagnosis(name, False, f"missing; install it: pip install {name}")


def probe(subject: str, *steps: str, advice: str = _BROKEN) -> Diagnosis:
    """Run checks (`steps`) of `sim.doctor_probes` in a child process, and return their result as a diagnosis.

    A broken driver or library can then crash or hang only the child process, and the diagnosis gives the `advice`.
    """
    command = [sys.executable, "-P", "-m", PROBES, *steps]  # -P: do not import a folder `sim` of the working directory
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PROBE_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        return Diagnosis(subject, False, f"no answer after {PROBE_TIMEOUT_S:g} s; {advice}")
    if done.returncode < 0:
        return Diagnosis(subject, False, f"crashed with {signal.Signals(-done.returncode).name}; {advice}")
    said = (done.stderr if done.returncode else done.stdout).strip().splitlines()
    return Diagnosis(subject, done.returncode == 0, said[-1] if said else f"ended with {done.returncode}")


def _cores(usable: int) -> Diagnosis:
    fine = usable >= 2
    return Diagnosis("cores", fine, f"{usable}; a run uses two" + ("" if fine else "; give the process a second core"))


def available_bytes() -> int | None:
    """Return the free memory of the machine or of the container, whichever is less [bytes]; None if it is unknown."""
    found = []
    if _MEMINFO.is_file():
        rows = (line.split() for line in _MEMINFO.read_text(encoding="utf-8").splitlines())
        found += [1024 * int(row[1]) for row in rows if row[0] == "MemAvailable:"]
    if (
        all(path.is_file() for path in (_CGROUP_MAX, _CGROUP_USED))
        and (limit := _CGROUP_MAX.read_text(encoding="utf-8").strip()).isdecimal()
    ):
        found.append(int(limit) - int(_CGROUP_USED.read_text(encoding="utf-8")) + _file_cache_bytes())
    return min(found, default=None)


def _file_cache_bytes() -> int:
    """Return how much of the container's memory holds files that were read, and is freed when it is needed [bytes]."""
    rows = (line.split() for line in _CGROUP_STAT.read_text(encoding="utf-8").splitlines()) if _CGROUP_STAT.is_file() else ()
    return sum(int(row[1]) for row in rows if row[0] == "inactive_file")


def _memory(available: int | None) -> Diagnosis:
    if available is None:
        return Diagnosis("memory", True, "unknown on this system")
    fine, detail = available >= NEEDED_BYTES, f"{available / _GIB:.1f} GiB free"
    needed = f"; a run needs {NEEDED_BYTES / _GIB:.1f} GiB; free memory, or raise the container's limit"
    return Diagnosis("memory", fine, detail if fine else detail + needed)
