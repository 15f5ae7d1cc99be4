"""A rendered walk is recorded as LEXIS sees it: one set of descriptors per keyframe, and LEXIS's own candidates."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import logit

from lexis.config import PlaceRecognitionConfig
from sim.baselines.places import EmbeddingSimilarity, LabelledRoom, RevisitProbability
from sim.bench.peers import place_walks as module
from sim.bench.peers.place_figures import answers, ranked
from sim.bench.peers.place_walks import record_walk, record_walks
from sim.harness import Scenario
from sim.harness.walk import with_walk_m
from sim.render.rig import RigConfig
from worlds.presets import sample_from_rooms


@pytest.fixture(scope="module")
def recorded():
    kept = {}

    def keeping(finished, seen):
        kept["run"] = finished
        return original(finished, seen)

    original = module._with_truth
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "_with_truth", keeping)
        house = sample_from_rooms(("kitchen", "bedroom"), seed=21)
        rig = RigConfig(width=96, height=72)
        scenario = Scenario(house=house, length_m=30.0, frame_rate_hz=3.0, rig=rig)
        return record_walk(scenario), kept["run"]


def test_evidence_has_one_row_per_keyframe_and_ends_at_the_query(recorded):
    walk, finished = recorded
    n = len(finished.estimate.frames)
    for each in (walk.seen.orb, walk.seen.akaze, walk.seen.patches, walk.seen.embeddings, walk.T_W_B):
        assert len(each) == n
    for square in (walk.seen.eligible, walk.seen.in_room, np.isfinite(walk.seen.estimated_m) & ~np.eye(n, dtype=bool)):
        assert not square[np.triu_indices(n)].any()
    assert walk.seen.eligible.any() and (walk.right & walk.seen.eligible).any()


def test_the_default_method_proposes_what_the_run_verified_except_for_improbable_keyframes(recorded):
    walk, finished = recorded
    least = float(logit(PlaceRecognitionConfig.least_probability))
    ranking = ranked(RevisitProbability().scores(walk.seen))
    given, verified = answers(ranking, least), finished.estimate.candidates
    assert [bool(ids) for _, ids in given] == [bool(ids) for _, ids in verified] and any(ids for _, ids in given)
    for likely, (_, ids), (_, others) in zip((ranking.scores >= least).sum(axis=1), given, verified, strict=True):
        assert ids[:likely] == others[:likely]


def test_the_method_of_the_paper_ranks_by_similarity_within_a_room(recorded):
    seen = recorded[0].seen
    everywhere, in_room = EmbeddingSimilarity().scores(seen), LabelledRoom().scores(seen)
    np.testing.assert_array_equal(in_room[seen.in_room], everywhere[seen.in_room])
    assert np.isneginf(in_room[~seen.in_room]).all() and seen.in_room.any() and (seen.eligible & ~seen.in_room).any()


def test_walks_are_as_long_as_asked_or_as_a_house_demands(monkeypatch):
    monkeypatch.setattr(module, "record_walk", lambda scenario: scenario)
    usual = Scenario(preset="uh2-apt", seed=500, frame_rate_hz=10.0)
    assert list(record_walks(["uh2-apt"], [500], 250.0, 10.0)) == [replace(usual, length_m=250.0)]
    (short,) = record_walks(["uh2-apt"], [500], 10.0, 10.0)
    assert short == with_walk_m(usual, 10.0) and short.length_m > 50.0
