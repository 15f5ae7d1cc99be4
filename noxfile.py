"""One way to run everything: `nox -s demo | tests | nightly | lint | bench | mutation`, with `-- ARGUMENTS` passed through.

All sessions share one environment (torch makes it several gigabytes). The session `env` builds it from the versions in
tests/constraints.txt, so that figures repeat, and does nothing until that file or pyproject.toml changes.
"""

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import nox

nox.needs_version = ">=2025.2.9"
nox.options.sessions = ["lint", "tests"]
nox.options.error_on_missing_interpreters = True

PYPROJECT = nox.project.load_toml("pyproject.toml")
SUPPORTED = nox.project.python_versions(PYPROJECT)
RUNNING = f"{sys.version_info.major}.{sys.version_info.minor}"
PYTHON = None if RUNNING in SUPPORTED else SUPPORTED[-1]  # None: the interpreter that runs nox

CONSTRAINTS = Path("tests", "constraints.txt")
TWO_PROCESSES = ("-n", "2", "--dist", "loadfile", "--no-loadscope-reorder")
"""Options of pytest. Files run in their own order, because xdist would run those with few tests last; some of them are the
longest, and one process would wait for the other."""

GL_PACKAGES = {"egl": ("libegl1", "libgl1-mesa-dri"), "osmesa": ("libosmesa6",)}
ENVIRONMENT = {
    "OMP_WAIT_POLICY": "PASSIVE", "GOMP_SPINCOUNT": "0",  # spinning threads starve each other on few cores
    "PYTHONDONTWRITEBYTECODE": "",  # where containers set it, each process would compile torch anew, for 10 s
}  # fmt: skip


@nox.session(python=PYTHON, venv_backend="uv|virtualenv", reuse_venv=True)
def env(session: nox.Session) -> None:
    """Make the environment that the other sessions share, and see that something renders off-screen."""
    ensure_gl(session)
    stamp = session.env_dir / "installed.sha256"
    wanted = hashlib.sha256(Path("pyproject.toml").read_bytes() + CONSTRAINTS.read_bytes()).hexdigest()
    if not stamp.exists() or stamp.read_text() != wanted:
        groups = nox.project.dependency_groups(PYPROJECT, "tests", "lint")
        # Python compiles a module when it is first imported. pip would compile all 17 000 files, which takes a minute.
        session.install("--editable", ".", *groups, "--constraint", str(CONSTRAINTS), env={"PIP_COMPILE": "0"})
        session.run("python", "-m", "sim.render.gl")
        stamp.write_text(wanted)


@nox.session(venv_backend="none", requires=["env"])
def demo(session: nox.Session) -> None:
    """A house, a walk, LEXIS, a report."""
    run(session, "lexis-sim", "demo", *session.posargs)


@nox.session(venv_backend="none", requires=["env"])
def tests(session: nox.Session) -> None:
    """All tests but the slow ones."""
    run(session, "pytest", *TWO_PROCESSES, *session.posargs)


@nox.session(venv_backend="none", requires=["env"])
def nightly(session: nox.Session) -> None:
    """All tests, the slow ones too, with new random examples, and with the lengths of all axes checked."""
    options = ["-m", "", "--hypothesis-profile=nightly"]
    run(session, "pytest", *TWO_PROCESSES, *options, *session.posargs, env={"CHECK_AXES": "1"})


@nox.session(venv_backend="none", requires=["env"])
def lint(session: nox.Session) -> None:
    """Ruff and mypy --strict."""
    run(session, "ruff", "check", ".")
    run(session, "ruff", "format", "--check", ".")
    run(session, "mypy")


@nox.session(venv_backend="none", requires=["env"])
def bench(session: nox.Session) -> None:
    """Benchmarks; `nox -s bench -- encoders` and so on."""
    run(session, "lexis-sim", "bench", *(session.posargs or ["speed"]))


@nox.session(venv_backend="none", requires=["env"])
def mutation(session: nox.Session) -> None:
    """Plant bugs into LEXIS, one at a time, and see which of them the suite `pr` finds."""
    run(session, "lexis-sim", "bench", "mutation", *session.posargs)


@nox.session(venv_backend="uv|virtualenv", reuse_venv=True)
def lock(session: nox.Session) -> None:
    """Write tests/constraints.txt, one set of versions for all Pythons; versions that fit stay, unless `-- --upgrade`."""
    session.install("uv")
    options = ["--universal", "--python-version", SUPPORTED[0], "--fork-strategy", "fewest", "--no-annotate", "--quiet"]
    groups = ["--group", "tests", "--group", "lint"]
    output = ["--custom-compile-command", "nox -s lock", "--output-file", str(CONSTRAINTS)]
    command = ["uv", "pip", "compile", "pyproject.toml", *options, *groups, *output, *session.posargs]
    session.run(*command, env={"UV_CONSTRAINT": pip_constraint()})


def pip_constraint() -> str:
    """Return the constraint file in pip's configuration, or "". uv does not read it, but both have to choose the same."""
    command = [sys.executable, "-m", "pip", "config", "get", "global.constraint"]
    return subprocess.run(command, capture_output=True, text=True).stdout.strip()


def run(session: nox.Session, command: str, *args: str, env: dict[str, str] | None = None) -> None:
    """Run a command of the shared environment."""
    directory = session.cache_dir.parent / "env" / "bin"
    session.run(str(directory / command), *args, env=ENVIRONMENT | (env or {}), external=True)


def ensure_gl(session: nox.Session) -> None:
    """Install the off-screen GL libraries where none works, or end the session with a line that says how to."""
    if sys.platform != "linux" or any(map(gl_works, GL_PACKAGES)):
        return
    prefix = root_prefix()
    if prefix is not None:
        for backend, packages in GL_PACKAGES.items():
            session.log(f"No off-screen GL; installing {' '.join(packages)}")
            if apt_install(prefix, packages) and gl_works(backend):
                return
    session.error("No off-screen GL. Run: sudo apt-get install libegl1 libgl1-mesa-dri (or libosmesa6)")


def gl_works(backend: str) -> bool:
    """Try a back end in a child process, which a broken driver may crash or hang."""
    command = [sys.executable, "-I", "-S", "sim/render/gl_probe.py", backend]
    try:
        return subprocess.run(command, capture_output=True, timeout=60).returncode == 0
    except subprocess.TimeoutExpired:
        return False


def root_prefix() -> list[str] | None:
    """Return the words that run apt-get as root without a password; None if there is no way."""
    if shutil.which("apt-get") is None:
        return None
    prefix = [] if os.geteuid() == 0 else ["sudo", "-n"]
    if prefix and (shutil.which("sudo") is None or subprocess.run([*prefix, "true"], capture_output=True).returncode):
        return None
    return [*prefix, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get"]


def apt_install(apt: list[str], packages: tuple[str, ...]) -> bool:
    """Install packages; refresh the lists only where that fails without."""
    install = [*apt, "install", "-y", "-q", "--no-install-recommends", *packages]
    if subprocess.run(install, capture_output=True).returncode == 0:
        return True
    subprocess.run([*apt, "update", "-q"])
    return subprocess.run(install).returncode == 0
