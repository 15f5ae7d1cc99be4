"""LEXIS in 60 houses of several families that nobody chose, without rendering."""

from sim.harness import worlds

FAMILIES = ("home", "ori", "uh2-apt", "uh2-office")


@worlds(presets=FAMILIES, n=60, fidelity="features", openness=(0.2, 0.9), max_rooms=6)
def test_most_labels_are_right_and_the_map_is_better_than_the_odometry(run):
    assert run.labels.accuracy >= 0.45
    assert run.floors.accuracy >= 0.85
    assert run.trajectory.ate_m <= run.trajectory.ate_odometry_m
    assert run.loops.precision >= 0.9
    assert run.coverage.rooms_visited == run.coverage.rooms
