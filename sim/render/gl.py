"""Chooses the off-screen OpenGL of MuJoCo before MuJoCo is imported.

MuJoCo reads ``MUJOCO_GL`` once, while it is imported. All of `sim` therefore imports MuJoCo from this module::

    from sim.render.gl import mujoco
"""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sim.errors import GraphicsError
from sim.render.gl_probe import PROBES
from sim.render.llvm_order import load_triton_library

PROBE_TIMEOUT_S = 20.0
"""Longest time to wait for the child process that tests a back end [s]."""

DISABLED = "disabled"
"""Value of ``MUJOCO_GL`` where no back end works. Physics and geometry still work then."""

HELP = "no off-screen OpenGL: install EGL (Debian, Ubuntu: apt-get install libegl1 libgl1-mesa-dri) or OSMesa (libosmesa6)"


_OFF = ("disabled", "disable", "off", "false", "0")
VALID = ("egl", "osmesa", "glfw", DISABLED)
"""Valid values of ``MUJOCO_GL`` on Linux."""
_SYNONYMS = (*_OFF, "enable", "enabled", "on", "true", "1", "glx")


def choose_backend() -> str:
    """Return the back end in ``MUJOCO_GL``. If the variable is not set or blank, set it to the first back end that works.

    EGL is tried before OSMesa, which new Mesa releases no longer have. If neither works, the result is `DISABLED`. On
    systems other than Linux, MuJoCo chooses. Raises `GraphicsError` if the variable has a value that MuJoCo does not know.
    """
    if sys.platform != "linux":
        return os.environ.get("MUJOCO_GL", "")
    if not os.environ.get("MUJOCO_GL", "").strip():
        os.environ["MUJOCO_GL"] = next(filter(_works, PROBES), DISABLED)
    backend = os.environ["MUJOCO_GL"].lower().strip()
    if backend not in (*VALID, *_SYNONYMS):
        raise GraphicsError(f"MUJOCO_GL is {backend!r}; valid: {', '.join(VALID)}, or unset it to have one chosen")
    return DISABLED if backend in _OFF else backend


def require_rendering() -> None:
    """Raise `GraphicsError`, which says what to install, if `choose_backend` finds no back end that renders."""
    if choose_backend() == DISABLED:
        raise GraphicsError(f"{HELP}; where one is installed, unset MUJOCO_GL")


@contextmanager
def graphics_errors(task: str) -> Iterator[None]:
    """Turn exceptions of MuJoCo and OpenGL in a `with` block into a `GraphicsError` that says what to change.

    `task` names, for the message, what the `with` block does.
    """
    try:
        yield
    except MemoryError as error:
        raise GraphicsError(f"{task}: {_MEMORY}") from error
    except _FAILURES as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        advice = HELP if isinstance(error, ImportError) else _LOST
        if any(word in reason.lower() for word in _OUT_OF_MEMORY):
            advice = _MEMORY
        raise GraphicsError(f"{task}: {advice} ({reason[:200]})") from error


def _works(backend: str) -> bool:
    """Return whether a back end works. It is tested in a child process, which a broken driver may crash or hang."""
    command = [sys.executable, "-I", "-S", str(Path(__file__).with_name("gl_probe.py")), backend]
    try:
        return subprocess.run(command, capture_output=True, timeout=PROBE_TIMEOUT_S).returncode == 0
    except subprocess.TimeoutExpired:
        return False


_CHOSEN = choose_backend()

if _CHOSEN != DISABLED:
    load_triton_library()  # before `import mujoco`, which loads OSMesa; EGL loads its driver with the first context

try:
    import mujoco
except (AttributeError, ImportError, OSError) as error:  # PyOpenGL raises any of these where a library is missing
    if isinstance(error, ModuleNotFoundError) and error.name == "mujoco":
        raise
    raise GraphicsError(f"MUJOCO_GL is {_CHOSEN!r}, which does not load here; {HELP}; or unset MUJOCO_GL") from error

from OpenGL.error import Error as OpenGLError  # noqa: E402 - MuJoCo tells PyOpenGL which platform

_FAILURES = (RuntimeError, ImportError, mujoco.FatalError, mujoco.UnexpectedError, OpenGLError)
_OUT_OF_MEMORY = ("memory", "alloc", "0x505", "bad_alloc")
_MEMORY = "too little memory; render smaller images, fewer houses at once, or free memory"
_LOST = "OpenGL failed or its context is lost; create a new renderer in the thread that uses it, and see `lexis-sim doctor`"


def device_name() -> str:
    """Return the device or software that renders in the current GL context, e.g. "llvmpipe (LLVM 15.0.6, 256 bits)"."""
    from OpenGL.GL import GL_RENDERER, glGetString

    return str((glGetString(GL_RENDERER) or b"an unknown device").decode())


__all__ = ["GraphicsError", "choose_backend", "device_name", "graphics_errors", "mujoco", "require_rendering"]

if __name__ == "__main__":
    require_rendering()
    mujoco.GLContext(64, 64).free()
    print(f"renders with {choose_backend()}")
