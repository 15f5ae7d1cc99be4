"""LEXIS in four small rendered houses, whose plans a robot drives."""

from sim.harness import worlds


@worlds(presets=("home",), n=4, fidelity="render", max_rooms=3, length_m=35.0)
def test_labels_floors_and_plans_are_right_on_images(run):
    assert run.labels.accuracy >= 0.5
    assert run.floors.accuracy >= 0.9
    assert run.trajectory.ate_m <= 0.3
    assert run.planning.collisions == 0
