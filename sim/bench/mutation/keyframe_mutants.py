"""Mistakes in the choice of keyframes, in what a keyframe keeps, and in the arithmetic of poses."""

from sim.bench.mutation.planting import Mutant

KEYFRAME_MUTANTS = (
    Mutant(
        "the covariance of a step is never reset",
        "keyframes.py",
        "            self._covariance = np.zeros((6, 6))\n            return frame",
        "            return frame",
    ),
    Mutant(
        "keyframes are two metres apart instead of half a metre",
        "keyframes.py",
        "reaches(self._path_since_keyframe, self._config.spacing_m)",
        "reaches(self._path_since_keyframe, 4.0 * self._config.spacing_m)",
    ),
    Mutant(
        "keyframes are spaced in time, as if the robot never stood still",
        "keyframes.py",
        "distance = float(np.linalg.norm(increment[:3, 3]))",
        "distance = 0.35",
    ),
    Mutant(
        "the path between keyframes ignores all axes but x",
        "keyframes.py",
        "distance = float(np.linalg.norm(increment[:3, 3]))",
        "distance = float(abs(increment[0, 3]))",
    ),
    Mutant(
        "a keyframe gets the index of the observation after it",
        "keyframe_window.py",
        "observation_index=observation.index,",
        "observation_index=observation.index + 1,",
    ),
    Mutant(
        "the last keyframes are lost at the end of the walk",
        "keyframe_window.py",
        "        self._entries.clear()\n        return ready",
        "        self._entries.clear()\n        return ready[:0]",
    ),
    Mutant(
        "a keyframe gets the embedding of the latest frame",
        "keyframe_window.py",
        "            embedding=first.embedding,",
        "            embedding=next(e.embeddings[0] for e in reversed(self._entries) if e.embeddings is not None),",
    ),
    Mutant(
        "the covariances of the steps between two keyframes are not added up",
        "keyframes.py",
        "self._covariance = compose_covariance(self._covariance, increment, covariance)",
        "self._covariance = covariance",
    ),
    Mutant(
        "the covariances that the odometry states are ignored",
        "keyframes.py",
        "self._covariance = compose_covariance(self._covariance, increment, covariance)",
        "self._covariance = compose_covariance(self._covariance, increment, np.diag([1e-6] * 3 + [1e-5] * 3))",
    ),
    Mutant(
        "the uncertainty of a step of the odometry is limited to five centimetres",
        "keyframes.py",
        "self._covariance = compose_covariance(self._covariance, increment, covariance)",
        "self._covariance = compose_covariance(self._covariance, increment, np.clip(covariance, -0.0025, 0.0025))",
    ),
    Mutant(
        "the poses of observations are kept without a copy",
        "slam.py",
        "        observation = with_copied_geometry(observation)\n",
        "",
    ),
    Mutant(
        "relative poses are composed in the wrong order",
        "maths/se3.py",
        "return np.asarray(inverse(T_a_b) @ T_a_c)",
        "return np.asarray(T_a_c @ inverse(T_a_b))",
    ),
    Mutant(
        "covariances are added without rotating them",
        "maths/se3.py",
        "return np.asarray(Ad @ first @ Ad.T + second)",
        "return np.asarray(first + second)",
    ),
    Mutant(
        "angles are half as large",
        "maths/se3.py",
        "return np.asarray(np.arctan2(np.sqrt(x * x + y * y + z * z), trace - 1.0))",
        "return np.asarray(0.5 * np.arctan2(np.sqrt(x * x + y * y + z * z), trace - 1.0))",
    ),
    Mutant(
        "the nearest neighbours of a keyframe include the keyframe itself",
        "maths/ties.py",
        "order = np.lexsort((indices, distances), axis=1)[:, 1:wanted]",
        "order = np.lexsort((indices, distances), axis=1)[:, : wanted - 1]",
    ),
)
