"""Rendering and torch work in one process in any order of imports, although each brings its own LLVM."""

import importlib.util
import itertools
import subprocess
import sys

import pytest

STEPS = {
    "render": "from sim.doctor_probes import draw; draw()",
    "torch": "import torch",
    "triton": "import triton",
    "encoder": "from lexis.encoder.open_clip_encoder import load_encoder; load_encoder('mini')",
}
QUICK = [("render", "triton"), ("triton", "render"), ("render", "encoder", "render")]
"""The first order is the one that used to crash; the last is that of a notebook that renders first."""

pytestmark = pytest.mark.skipif(importlib.util.find_spec("triton") is None, reason="torch has no triton on this system")


def python(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)


def follow(order):
    done = python("\n".join(STEPS[step] for step in order))
    assert done.returncode == 0, f"{' > '.join(order)} ended with {done.returncode}: {done.stderr[-500:]}"


@pytest.mark.parametrize("order", QUICK, ids=" > ".join)
def test_the_usual_orders(order):
    follow(order)


@pytest.mark.slow
@pytest.mark.parametrize("order", list(itertools.permutations(STEPS)), ids=" > ".join)
def test_every_order(order):
    follow(order)


def test_physics_and_geometry_load_neither_torch_nor_triton():
    done = python("import sys, sim.render.scene, sim.harness.figures; print(*{'torch', 'triton'} & set(sys.modules))")
    assert done.returncode == 0 and done.stdout.split() == []
