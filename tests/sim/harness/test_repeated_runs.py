"""Runs of one scenario share what the sensor has computed, and no run can change what the next one gets."""

from dataclasses import replace

import numpy as np

from sim.feature_sensor import sensed_camera
from sim.harness.adapters.lexis import Lexis
from sim.harness.adapters.odometry_only import OdometryOnly
from sim.harness.runner import run
from sim.harness.scenario import Scenario
from worlds.presets import sample_from_rooms

SCENARIO = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=33), length_m=20.0, frame_rate_hz=2.0, fidelity="features"
)


class Recorder(OdometryOnly):
    """Keeps copies of everything that it is given, and then overwrites what it was given."""

    def start_on_features(self, camera, room_names, features):
        self.given = [camera.T_B_C.copy()]
        self.start(camera, room_names)
        camera.T_B_C[...] = 0.0

    def process(self, observation):
        super().process(replace(observation, T_O_B=observation.T_O_B.copy()))
        for array in (observation.image.embedding, observation.T_O_B, observation.increment_covariance):
            self.given.append(array.copy())
            array[...] = 0.0


def test_a_slam_that_overwrites_its_input_does_not_change_the_next_run():
    first, second = Recorder(), Recorder()
    run(SCENARIO, first)
    run(SCENARIO, second)
    assert len(first.given) == len(second.given) > 30
    assert all(np.array_equal(a, b) for a, b in zip(first.given, second.given, strict=True))


def test_the_harness_remembers_the_odometry_that_it_gave():
    finished = run(SCENARIO, Recorder())
    np.testing.assert_array_equal(finished.odometry_poses, run(SCENARIO, OdometryOnly()).odometry_poses)


class SpoilsLoops(Lexis):
    """LEXIS with loops whose covariances are overwritten."""

    def start_on_features(self, camera, room_names, features):
        def verifier(*arguments):
            verified = features.verifier(*arguments)
            for edge in verified.edges:
                edge.covariance[...] *= 1e4
            return verified

        super().start_on_features(camera, room_names, replace(features, verifier=verifier))


def test_a_slam_that_overwrites_loops_does_not_change_the_next_run():
    scenario = replace(SCENARIO, length_m=50.0)
    before = run(scenario).estimate
    run(scenario, SpoilsLoops())
    again = run(scenario).estimate
    assert len(before.loops.query)
    np.testing.assert_array_equal(again.T_W_B, before.T_W_B)


def test_percepts_are_computed_once_for_all_runs_of_a_scenario(monkeypatch):
    scenario = replace(SCENARIO, seed=34)
    run(scenario, Recorder())
    monkeypatch.setattr(sensed_camera, "look", None)
    run(scenario, Recorder())
