"""The choice of the OpenGL back end: the user's setting takes precedence, and a crashing driver does no harm."""

import os
import subprocess
import sys

import pytest

from sim.errors import GraphicsError, SimError
from sim.render import gl
from sim.render.gl_probe import PROBES, works


@pytest.fixture
def unset(monkeypatch):
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    return monkeypatch


@pytest.fixture
def probe(unset, tmp_path):
    """A function that replaces the script which tries a back end in a child process."""

    def replace(script):
        (tmp_path / "gl_probe.py").write_text(script)
        unset.setattr(gl, "__file__", str(tmp_path / "gl.py"))

    return replace


def test_egl_is_preferred_and_osmesa_is_the_fallback(probe, unset):
    assert list(PROBES) == ["egl", "osmesa"]
    probe("")
    assert gl.choose_backend() == "egl"
    unset.delenv("MUJOCO_GL")
    probe("import sys; sys.exit(sys.argv[1] != 'osmesa')")
    assert gl.choose_backend() == "osmesa"


@pytest.mark.parametrize("blank", ["", " "])
def test_a_blank_choice_is_none(probe, unset, blank):
    """MuJoCo itself would take a window, for which containers have no display."""
    unset.setenv("MUJOCO_GL", blank)
    probe("")
    assert gl.choose_backend() == os.environ["MUJOCO_GL"] == "egl"


def test_the_users_choice_stands(probe, unset, tmp_path):
    unset.setenv("MUJOCO_GL", "glfw")
    probe("from pathlib import Path; Path(__file__).with_name('probed').touch()")
    assert gl.choose_backend() == "glfw"
    assert not (tmp_path / "probed").exists()


def test_without_gl_rendering_says_what_to_install_and_the_rest_goes_on(probe):
    probe("raise SystemExit(1)")
    assert gl.choose_backend() == gl.DISABLED
    with pytest.raises(SimError, match="apt-get install libegl1 libgl1-mesa-dri") as error:
        gl.require_rendering()
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("fault", ["import os; os.abort()", "raise SystemExit(1)", "import time; time.sleep(60)"])
def test_a_driver_that_crashes_or_hangs_harms_nobody(probe, unset, fault):
    probe(fault)
    unset.setattr(gl, "PROBE_TIMEOUT_S", 0.5)
    assert gl.choose_backend() == gl.DISABLED


def test_a_missing_library_is_no_error(monkeypatch):
    monkeypatch.setattr("sim.render.gl_probe.ctypes.util.find_library", lambda name: "libthere-is-none.so")
    assert not any(works(backend) for backend in PROBES)


def test_mujoco_makes_a_context_with_the_choice():
    gl.require_rendering()
    context = gl.mujoco.GLContext(64, 64)
    context.make_current()
    context.free()


@pytest.mark.parametrize("backend", ["vulkan", "eglx"])
def test_a_back_end_that_mujoco_does_not_know_is_named(unset, backend):
    unset.setenv("MUJOCO_GL", backend)
    with pytest.raises(GraphicsError, match=f"MUJOCO_GL is '{backend}'; valid: egl, osmesa, glfw, disabled, or unset it"):
        gl.choose_backend()


def test_switched_off_by_any_of_mujocos_words(unset):
    for word in ("disable", "off", "FALSE", "0"):
        unset.setenv("MUJOCO_GL", word)
        with pytest.raises(GraphicsError, match="unset MUJOCO_GL"):
            gl.require_rendering()


@pytest.mark.parametrize(
    ("failure", "advice"),
    [
        (RuntimeError("Failed to make the EGL context current."), "its context is lost; create a new renderer"),
        (gl.mujoco.FatalError("Could not allocate memory\nfor shadow map"), "too little memory; render smaller images"),
        (MemoryError(), "too little memory"),
        (ImportError("Failed to import OpenGL backend"), "apt-get install libegl1"),
    ],
)
def test_failures_of_opengl_say_what_to_do_in_one_line(failure, advice):
    with pytest.raises(GraphicsError, match=f"drawing: .*{advice}") as error, gl.graphics_errors("drawing"):
        raise failure
    assert "\n" not in str(error.value) and error.value.__cause__ is failure


def test_a_missing_library_is_found_while_mujoco_is_imported():
    """This runs in a separate process, whose dynamic loader finds no EGL."""
    hide = (
        "import ctypes, sys; load = ctypes.CDLL.__init__\n"
        "def refuse(self, name, *rest, **options):\n"
        "    if 'EGL' in str(name): raise OSError('no such file')\n"
        "    load(self, name, *rest, **options)\n"
        "ctypes.CDLL.__init__ = refuse; import ctypes.util; find = ctypes.util.find_library\n"
        "ctypes.util.find_library = lambda name: None if 'EGL' in name else find(name)\n"
        "from sim.errors import GraphicsError\n"
        "try: import sim.render.gl\n"
        "except GraphicsError as error: print(error)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", hide], capture_output=True, text=True, env=os.environ | {"MUJOCO_GL": "egl"}
    )
    assert done.stdout.startswith("MUJOCO_GL is 'egl', which does not load here; no off-screen OpenGL: install EGL")
    assert done.stdout.count("\n") == 1
