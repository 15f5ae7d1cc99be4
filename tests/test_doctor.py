"""The doctor finds what is missing, and says what to change."""

import pytest

from sim import doctor


def finding(subject):
    return next(finding for finding in doctor.examine() if finding.subject == subject)


@pytest.fixture(autouse=True)
def no_encoder(monkeypatch):
    monkeypatch.setattr(doctor, "_encode", lambda: "not looked at")


def test_all_is_fine_here():
    assert all(finding.fine for finding in doctor.examine())


def test_too_little_memory_is_found(monkeypatch):
    monkeypatch.setattr(doctor, "available_bytes", lambda: 1 << 29)
    found = finding("memory")
    assert not found.fine and "0.5 GiB free; a run needs 2.0 GiB" in found.detail
    monkeypatch.setattr(doctor, "available_bytes", lambda: None)
    assert finding("memory").fine


def test_the_container_counts_too(monkeypatch, tmp_path):
    for name, text in (("meminfo", "MemTotal: 9 kB\nMemAvailable: 4000 kB\n"), ("max", "3000000\n"), ("used", "1000000\n")):
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(doctor, "_MEMINFO", tmp_path / "meminfo")
    monkeypatch.setattr(doctor, "_CGROUP_MAX", tmp_path / "max")
    monkeypatch.setattr(doctor, "_CGROUP_USED", tmp_path / "used")
    assert doctor.available_bytes() == 2_000_000
    (tmp_path / "max").write_text("max\n")
    assert doctor.available_bytes() == 4_096_000


@pytest.mark.parametrize("backend", ["off", "vulkan"])
def test_a_back_end_that_draws_nothing_is_found(monkeypatch, backend):
    monkeypatch.setenv("MUJOCO_GL", backend)
    monkeypatch.setattr("sys.platform", "linux")
    found = finding("off-screen OpenGL")
    assert not found.fine and "MUJOCO_GL" in found.detail and "\n" not in found.detail


def test_a_lost_context_is_found(monkeypatch):
    def lost(*_):
        raise RuntimeError("Failed to make the EGL context current.")

    monkeypatch.setattr("sim.gl.mujoco.Renderer", lost)
    found = finding("off-screen OpenGL")
    assert not found.fine and "context is lost" in found.detail


def test_a_missing_package_is_found(monkeypatch):
    monkeypatch.setattr(doctor, "PACKAGES", ("no-such-package",))
    assert finding("no-such-package").detail == "missing; install it: pip install no-such-package"
