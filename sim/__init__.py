"""The simulator and the test harness: MuJoCo renders generated houses, a camera moves through them, and a SLAM is tested.

The package joins `worlds`, which knows every house exactly, with `lexis`, which sees only observations. Read `session.py`
first: it yields pairs of an observation and the truth, and only the observation reaches the SLAM. Then read `harness`, which
builds a session from a `Scenario`, runs a SLAM on it and evaluates the result. A session consists of:

- `tours`: the path and motion of the camera.
- `odometry`: the drifting estimate of that motion, and a simulated inertial sensor.
- `render`: a house as a MuJoCo model, and images of it.
- `feature_sensor`: a stand-in for rendering that predicts what LEXIS would extract from the images.
- `faults`: dropped frames, blur, moved furniture and other disturbances.

The other packages build on these: `robot` drives LEXIS's plans in MuJoCo, `report` shows a run in one HTML file, `record`
writes a dataset, `programs` tests SLAM programs in any language, `suites` checks any SLAM by ready claims and laws,
`verdicts` judges the results of many runs, `bench` measures, `baselines` holds other methods for comparison, `training`
trains the shipped encoder, `feature_fitting` fits the model of the feature sensor, `pytest_plugin` offers runs in pytest,
and `commands` is the command line.

Glossary:

- run: one house, one tour, one odometry and one SLAM, with all results.
- tour: the camera's path through a house, with a pose for every frame.
- walk: a house with a tour through it and the odometry along the tour: what a run needs before images and a SLAM.
- fidelity: the input of LEXIS. "render" stands for images, "features" for the predictions of the feature sensor.
- rig: the cameras that are mounted on one body.
- fault: a disturbance of a run. A fault of the stream changes observations. A fault of the world changes the house, or adds
  moving people and doors.
- take: the data that all sensors of a recording report on one tour.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
