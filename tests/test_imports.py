"""The direction of imports: `sim` may import `lexis` and `worlds`, which import neither `sim` nor each other."""

import ast
from collections.abc import Iterator
from pathlib import Path

import networkx
import pytest

ROOT = Path(__file__).parent.parent
FORBIDDEN = {
    "worlds": {"sim", "lexis", "mujoco"},
    "lexis": {"worlds", "sim", "mujoco"},
    "sim": set(),
}


def imported(source: str) -> Iterator[str]:
    """Names of the top-level packages that a module imports, including imports inside functions and by name."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module.partition(".")[0]
        elif isinstance(node, ast.Call) and _called(node) in {"import_module", "__import__"}:
            yield from (str(name.value).partition(".")[0] for name in node.args[:1] if isinstance(name, ast.Constant))


def _called(call: ast.Call) -> str:
    return call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")


@pytest.mark.parametrize("package", FORBIDDEN)
def test_a_package_imports_only_what_lies_before_it(package):
    modules = sorted((ROOT / package).rglob("*.py"))
    assert modules
    found = {str(path.relative_to(ROOT)): FORBIDDEN[package] & set(imported(path.read_text())) for path in modules}
    assert {path: names for path, names in found.items() if names} == {}


def test_mujoco_comes_from_sim_gl_alone():
    """Otherwise MuJoCo could be imported before its OpenGL back end is chosen."""
    importers = [path.name for path in (ROOT / "sim").rglob("*.py") if "mujoco" in set(imported(path.read_text()))]
    assert importers == ["gl.py"]


@pytest.mark.parametrize(
    "source",
    [
        "import sim",
        "import sim.render.gl as g",
        "from sim.render.gl import mujoco",
        "def f():\n    from sim import gl",
        "importlib.import_module('sim.render.gl')",
    ],
)
def test_every_form_of_import_is_seen(source):
    assert list(imported(source)) == ["sim"]


def package(module):
    """The part of the project that a module belongs to: a package or a module directly below `lexis`, `sim` or `worlds`."""
    return ".".join(module.split(".")[:2])


def imports_of(path):
    """The modules of this project that a file imports, also inside functions."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] in ("lexis", "sim", "worlds"):
            for alias in node.names:
                name = f"{node.module}.{alias.name}"
                whole = ROOT / name.replace(".", "/")
                yield name if whole.is_dir() or whole.with_suffix(".py").exists() else node.module


@pytest.mark.parametrize("top", ["lexis", "sim", "worlds"])
def test_packages_do_not_import_each_other_in_circles(top):
    graph = networkx.DiGraph()
    for path in (ROOT / top).rglob("*.py"):
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        edges = ((package(module), package(imported)) for imported in imports_of(path))
        graph.add_edges_from((a, b) for a, b in edges if a != b and a.startswith(f"{top}.") and b.startswith(f"{top}."))
    assert [component for component in networkx.strongly_connected_components(graph) if len(component) > 1] == []
