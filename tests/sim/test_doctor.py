"""The doctor finds what is missing and says what to change; it survives probes that crash or hang."""

import os
import platform
from pathlib import Path

import pytest

from sim import doctor, doctor_probes


def finding(subject):
    return next(finding for finding in doctor.examine() if finding.subject == subject)


@pytest.fixture(autouse=True)
def probing(monkeypatch, tmp_path):
    """Child processes run other code than the probes, which take seconds; the fixture's value changes that code."""

    def replace(code):
        (tmp_path / "other_probes.py").write_text(code)

    paths = filter(None, (str(tmp_path), os.environ.get("PYTHONPATH")))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(paths))
    monkeypatch.setattr(doctor, "PROBES", "other_probes")
    replace("print('not looked at')")
    return replace


def test_all_is_fine_on_a_machine_with_memory_and_two_cores(monkeypatch):
    monkeypatch.setattr(doctor, "available_bytes", lambda: 4 << 30)
    monkeypatch.setattr(doctor, "usable_cores", lambda: 2)
    assert all(finding.fine for finding in doctor.examine())


def test_too_little_memory_is_found(monkeypatch):
    monkeypatch.setattr(doctor, "available_bytes", lambda: 1 << 29)
    found = finding("memory")
    assert not found.fine and "0.5 GiB free; a run needs 2.0 GiB" in found.detail
    monkeypatch.setattr(doctor, "available_bytes", lambda: None)
    assert finding("memory").fine


def test_the_memory_limit_of_a_container_counts(monkeypatch, tmp_path):
    texts = {
        "meminfo": "MemTotal: 9 kB\nMemAvailable: 4000 kB\n",
        "max": "3000000\n",
        "used": "1000000\n",
        "stat": "anon 9\n",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(doctor, "_MEMINFO", tmp_path / "meminfo")
    monkeypatch.setattr(doctor, "_CGROUP_MAX", tmp_path / "max")
    monkeypatch.setattr(doctor, "_CGROUP_USED", tmp_path / "used")
    monkeypatch.setattr(doctor, "_CGROUP_STAT", tmp_path / "stat")
    assert doctor.available_bytes() == 2_000_000
    (tmp_path / "stat").write_text("anon 900\ninactive_file 600000\nactive_file 50\n")
    assert doctor.available_bytes() == 2_600_000
    (tmp_path / "max").write_text("max\n")
    assert doctor.available_bytes() == 4_096_000


def test_a_distribution_of_another_name_costs_no_result(monkeypatch):
    """OpenCV may be installed as `opencv-python`, for example."""
    monkeypatch.setattr(doctor, "PACKAGES", ("numpy", "no-such-distribution"))
    doctor._package_versions.cache_clear()
    found = doctor.versions()
    doctor._package_versions.cache_clear()
    assert found["no-such-distribution"] is None and found["numpy"] is not None


@pytest.mark.parametrize(
    ("path", "within"),
    [
        ("/home/me/opencv_ws/.venv/lib/python3.11/site-packages/numpy.libs", ("numpy.libs",)),
        ("/home/me/.venv/lib/python3.11/site-packages/scipy.libs", ("scipy.libs",)),
        ("/opt/conda/envs/scipy/lib", ()),
    ],
)
def test_only_folders_of_packages_tell_whose_library_it_is(path, within):
    assert doctor._within_packages(Path(path).parts) == within


@pytest.mark.parametrize("backend", ["off", "vulkan"])
def test_a_back_end_that_draws_nothing_is_found(monkeypatch, backend):
    monkeypatch.setenv("MUJOCO_GL", backend)
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setattr(doctor, "PROBES", "sim.doctor_probes")
    found = doctor.probe("off-screen OpenGL", "draw")
    assert not found.fine and "MUJOCO_GL" in found.detail and "\n" not in found.detail


def test_a_lost_context_is_found(monkeypatch, capsys):
    def lost(*_):
        raise RuntimeError("Failed to make the EGL context current.")

    monkeypatch.setattr("sim.render.gl.mujoco.Renderer", lost)
    assert doctor_probes.main(["draw"]) == 1
    assert "context is lost" in capsys.readouterr().err


def test_a_probe_that_crashes_is_found(probing):
    probing("import os, sys; os.abort() if 'encode' in sys.argv else print('egl draws')")
    assert finding("off-screen OpenGL").fine
    found = finding("encoder mini")
    assert not found.fine and found.detail.startswith("crashed with SIGABRT; update the graphics driver")


def test_a_probe_that_hangs_is_found(probing, monkeypatch):
    probing("import time; time.sleep(60)")
    monkeypatch.setattr(doctor, "PROBE_TIMEOUT_S", 0.5)
    found = doctor.probe("off-screen OpenGL", "draw")
    assert not found.fine and found.detail.startswith("no answer after 0.5 s; ")


@pytest.mark.parametrize(
    ("code", "detail"),
    [
        ("raise SystemExit('no driver')", "no driver"),
        ("import no_such_module", "ModuleNotFoundError: No module named 'no_such_module'"),
        ("raise SystemExit(3)", "ended with 3"),
    ],
)
def test_a_probe_that_fails_says_why_in_one_line(probing, code, detail):
    probing(code)
    assert doctor.probe("off-screen OpenGL", "draw") == doctor.Diagnosis("off-screen OpenGL", False, detail)


@pytest.mark.parametrize("missing", [False, True])
def test_an_opencv_without_akaze_is_found(missing, monkeypatch, capsys):
    """OpenCV 5 has none, and another distribution of OpenCV may lie in place of ours."""
    if missing:
        monkeypatch.delattr("cv2.AKAZE")
    assert doctor_probes.main(["detect"]) == missing
    said = capsys.readouterr()
    assert "has no AKAZE; valid: 'opencv-python-headless" in said.err if missing else "in an image of noise" in said.out


@pytest.mark.parametrize(("fine", "steps"), [(True, "draw encode"), (False, "encode")])
def test_the_encoder_is_tried_after_rendering_where_that_works(probing, fine, steps):
    """Rendering before torch is imported has crashed in the past. Where nothing renders, the encoder is tried alone."""
    probing(f"import sys; print(*sys.argv[1:]); sys.exit({int(not fine)} if sys.argv[1:] == ['draw'] else 0)")
    assert finding("off-screen OpenGL").fine is fine
    assert finding("encoder mini").detail == steps


def test_a_missing_package_is_found(monkeypatch):
    monkeypatch.setattr(doctor, "PACKAGES", ("no-such-package",))
    assert finding("no-such-package").detail == "missing; install it: pip install no-such-package"


def test_versions_name_what_shapes_a_result():
    found = doctor.versions()
    assert {"torch", "torchvision", "timm", "scipy", "shapely", "numpy"} <= set(found)
    assert found["machine"] == platform.machine()
    assert found["gl"] == os.environ.get("MUJOCO_GL")
    assert all(value is None or value == value.strip() != "" for value in found.values())


@pytest.mark.parametrize("folder", ["numpy.libs", "numpy/.dylibs", "../lib"])
def test_the_openblas_of_numpy_is_told_from_those_of_other_packages(monkeypatch, folder):
    """Its file is called libscipy_openblas in numpy too, so the path has to tell whose it is."""
    folders = {"/env/site-packages/opencv_python_headless.libs": "Zen", "/env/site-packages/scipy.libs": "Nehalem"}
    libraries = [
        {"internal_api": "openblas", "filepath": f"{place}/libscipy_openblas.so", "architecture": name}
        for place, name in (folders | {f"/env/site-packages/{folder}": "Haswell"}).items()
    ]
    monkeypatch.setattr(doctor, "threadpool_info", lambda: libraries)
    assert doctor.versions()["openblas_kernels"] == "Haswell"
