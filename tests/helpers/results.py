"""A result of a run with made-up figures, for tests of what is done with results."""

from sim.harness import results

RESULT = results.RunResult(
    seed=7,
    preset="home",
    fidelity="features",
    slam="MadeUp",
    encoder=None,
    odometry="multicam",
    house=results.HouseFigures(rooms=5, floors=1, area_m2=80.0, openness=0.5),
    run=results.WalkFigures(path_m=60.0, duration_s=120.0, frames=240, keyframes=100),
    labels=results.LabelFigures(accuracy=0.9, per_room={"kitchen": 0.8}),
    rooms=results.RoomFigures(pq=0.7),
    floors=results.FloorFigures(accuracy=1.0, count_error=0),
    loops=results.LoopFigures(),
    place_recognition={},
    coverage=results.CoverageFigures(rooms_visited=5, rooms=5, path_covered=1.0),
    trajectory=results.TrajectoryFigures(ate_odometry_m=0.4, ate_m=0.2),
    planning=results.PlanningFigures(),
    time=results.TimeFigures(0.1, 0.1, 1.0, 1.0, {}, 60.0),
    versions={},
    scenario="0123456789abcdef",
)
