"""The probabilities that LEXIS states for labels tell right labels from wrong ones."""

from lexis.evaluation import reliability
from sim.bench.peers.certainty import measure_certainty
from sim.harness import Scenario


def test_labels_that_are_stated_to_be_sure_are_right_more_often():
    found = measure_certainty(
        [Scenario(preset="home", seed=seed, fidelity="features", frame_rate_hz=2.0) for seed in (103, 104, 105)]
    )
    doubted, *_, sure = reliability(found.keyframes.stated, found.keyframes.right, (0.0, 0.5, 0.9, 0.98, 1.0))
    assert doubted.predictions > 10 and sure.predictions > 10
    assert sure.right > 0.95 > 0.75 > doubted.right
    assert len(found.rooms.stated) >= 24 and (found.rooms.stated <= 1.0).all()
