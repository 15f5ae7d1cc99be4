"""The choice of the GL back end: the user's word counts, a crash of a driver does not."""

import sys

import pytest

from sim import gl
from sim.errors import SimError
from sim.gl_probe import PROBES, works


@pytest.fixture
def unset(monkeypatch):
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    return monkeypatch


def test_egl_is_preferred_and_osmesa_is_the_fallback(unset):
    assert list(PROBES) == ["egl", "osmesa"]
    unset.setattr(gl, "_works", lambda backend: backend == "osmesa")
    assert gl.choose_backend() == "osmesa"


def test_the_users_choice_stands(unset):
    unset.setenv("MUJOCO_GL", "glfw")
    unset.setattr(gl, "_works", lambda backend: pytest.fail("probed"))
    assert gl.choose_backend() == "glfw"


def test_without_gl_rendering_says_what_to_install_and_the_rest_goes_on(unset):
    unset.setattr(gl, "_works", lambda backend: False)
    assert gl.choose_backend() == gl.DISABLED
    with pytest.raises(SimError, match="apt-get install libegl1 libgl1-mesa-dri") as error:
        gl.require_rendering()
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("fault", ["import os; os.abort()", "raise SystemExit(1)", "import time; time.sleep(60)"])
def test_a_driver_that_crashes_or_hangs_harms_nobody(unset, tmp_path, fault):
    (tmp_path / "gl_probe.py").write_text(fault)
    unset.setattr(gl, "__file__", str(tmp_path / "gl.py"))
    unset.setattr(gl, "_PROBE_TIMEOUT_S", 0.5)
    assert not gl._works("egl")


def test_a_missing_library_is_no_error(monkeypatch):
    monkeypatch.setattr("sim.gl_probe.ctypes.util.find_library", lambda name: "libthere-is-none.so")
    assert not any(works(backend) for backend in PROBES)


def test_mujoco_makes_a_context_with_the_choice():
    gl.require_rendering()
    context = gl.mujoco.GLContext(64, 64)
    context.make_current()
    context.free()
