"""The off-screen OpenGL of MuJoCo, chosen before MuJoCo is imported.

MuJoCo reads ``MUJOCO_GL`` once, while it is imported. So `sim` imports it from here and nowhere else::

    from sim.gl import mujoco
"""

import os
import subprocess
import sys
from pathlib import Path

from sim.errors import GraphicsError
from sim.gl_probe import PROBES

_PROBE_TIMEOUT_S = 20.0

DISABLED = "disabled"
"""What ``MUJOCO_GL`` is set to where nothing renders: physics and geometry still work."""

HELP = "no off-screen OpenGL: install EGL (Debian, Ubuntu: apt-get install libegl1 libgl1-mesa-dri) or OSMesa (libosmesa6)"


def choose_backend() -> str:
    """Set ``MUJOCO_GL`` to the first back end that works, unless it is set already; return it.

    EGL comes before OSMesa, which new Mesa releases no longer have. Other systems than Linux choose for themselves.
    """
    if "MUJOCO_GL" not in os.environ and sys.platform == "linux":
        os.environ["MUJOCO_GL"] = next(filter(_works, PROBES), DISABLED)
    return os.environ.get("MUJOCO_GL", "")


def require_rendering() -> None:
    """Raise `GraphicsError`, which says what to install, where `choose_backend` found nothing that renders."""
    if choose_backend() == DISABLED:
        raise GraphicsError(HELP)


def _works(backend: str) -> bool:
    """Try a back end in a child process, which a broken driver may crash or hang."""
    command = [sys.executable, "-I", "-S", str(Path(__file__).with_name("gl_probe.py")), backend]
    try:
        return subprocess.run(command, capture_output=True, timeout=_PROBE_TIMEOUT_S).returncode == 0
    except subprocess.TimeoutExpired:
        return False


choose_backend()

import mujoco  # noqa: E402 - MuJoCo must see the choice

__all__ = ["GraphicsError", "choose_backend", "mujoco", "require_rendering"]

if __name__ == "__main__":
    require_rendering()
    mujoco.GLContext(64, 64).free()
    print(f"renders with {choose_backend()}")
