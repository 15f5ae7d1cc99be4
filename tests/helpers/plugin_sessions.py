"""Test modules and options for pytest sessions of the plugin, with a SLAM that takes no time."""

import re

SLAM = """
import os

import numpy as np
import pytest
from sim.harness import Estimate, worlds

class Stub:
    def start(self, camera, names):
        self.frames, self.poses, self.label = [], [], names.index("kitchen")
    def process(self, observation):
        self.frames.append(observation.index)
        self.poses.append(observation.T_O_B)
    def finish(self):
        return Estimate(np.array(self.frames), T_W_B=np.array(self.poses), labels=np.full(len(self.frames), self.label))

class Lost(Stub):
    def process(self, observation):
        if observation.index == 20:
            raise RuntimeError("lost")
        super().process(observation)

@pytest.fixture
def slam():
    return Stub()

small = worlds(max_rooms=2, n=1, frame_rate_hz=2.0, encoder="oracle")
"""


LAYOUT = """
from sim.harness import worlds

@worlds(presets=("home", "office"), openness=(0.2, 0.4), max_rooms=3, n=3, fidelity="layout")
def test_house(scenario):
    assert scenario.seed < 1_000_000
"""


LIGHT = """
import types
from sim.harness.run_settings import with_listed_house
from sim.harness.world_tests import FreshWorld
FreshWorld.scenario = lambda self: types.SimpleNamespace(seed=self.seed)
"""
"""A conftest for tests in processes of their own that look at names and seeds of houses only."""


def ids(result):
    """The ids that `--collect-only -q` prints."""
    return re.findall(r"^.*::(?:\w+)\[(.*)\]$", result.stdout.str(), re.MULTILINE)


DRIFTS = """
@small
def test_drift(run):
    print("ran")
    if run.odometry == "perfect":
        raise ValueError("another failure")
    assert run.labels.accuracy > 2.0
"""
