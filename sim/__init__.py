"""The simulator and the test harness: MuJoCo renders generated houses, a camera moves through them, and a SLAM is tested.

The package joins `worlds`, which knows every house exactly, with `lexis`, which sees only observations. Read `session.py`
first: it yields pairs of an observation and the truth, and only the observation reaches the SLAM. Then read `harness`, which
builds a session from a `Scenario`, runs a SLAM on it and evaluates the result. A session consists of:

- `tours`: the path and motion of the camera.
- `odometry`: the drifting estimate of that motion, and the inertial sensor.
- `render`: a house as a MuJoCo model, and images of it.
- `feature_sensor`: a stand-in for rendering that predicts what LEXIS would extract from the images.
- `faults`: dropped frames, blur, moved furniture and other disturbances.

Other packages use runs: `robot` drives plans in MuJoCo, `report` shows a run in one HTML file, `record` writes a dataset,
`programs` puts programs in any language under test, `verdicts` judges the results of many runs, `bench` measures,
`baselines` are other methods to compare with, `training` makes the shipped encoder, `feature_fitting` the model of the
feature sensor, `pytest_plugin` brings runs to pytest, and `commands` is the command line.

Glossary:

- run: one house, one tour, one odometry and one SLAM, with all results.
- tour: the camera's path through a house, with a pose for every frame.
- fidelity: "render" gives LEXIS images, "features" gives it what the feature sensor predicts.
- rig: the cameras that share a body.
- fault of the stream: it changes observations. A fault of the world changes what there is to see.
- take: the data that all sensors of a recording report on one tour.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
