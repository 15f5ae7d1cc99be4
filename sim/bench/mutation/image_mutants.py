"""Mistakes in what is made of images: features, landmarks, PnP and brightness."""

from sim.bench.mutation.planting import Mutant

IMAGE_MUTANTS = (
    Mutant(
        "images are passed to the encoder as BGR",
        "perception.py",
        "encoder.encode_image(seen)",
        "encoder.encode_image(seen[..., ::-1].copy())",
    ),
    Mutant(
        "the pose of the camera on the body is forgotten in the triangulation",
        "landmarks.py",
        "T_O_C = np.stack([view.T_O_B @ camera.T_B_C for view in (reference, *supports)])",
        "T_O_C = np.stack([view.T_O_B for view in (reference, *supports)])",
    ),
    Mutant(
        "x and y of key points are swapped",
        "features.py",
        "np.array([keypoint.pt for keypoint in keypoints], np.float32)",
        "np.array([keypoint.pt[::-1] for keypoint in keypoints], np.float32)",
    ),
    Mutant(
        "descriptors are matched without the ratio test",
        "features.py",
        "distinct = (forward[:, 0] < forward[:, 1]) & (forward[:, 0] <= ratio * forward[:, 1])",
        "distinct = np.ones(len(rows), bool)",
    ),
    Mutant(
        "landmarks with hardly any parallax are kept",
        "landmarks.py",
        ">= config.min_parallax_rad",
        ">= 0.01 * config.min_parallax_rad",
    ),
    Mutant(
        "key points thirty pixels from their landmark count as inliers",
        "locator.py",
        "        limit_px = self._config.max_reprojection_px\n",
        "        limit_px = 10.0 * self._config.max_reprojection_px\n",
    ),
    Mutant(
        "six inliers in one spot of the image confirm a loop",
        "locator.py",
        "        if matches < config.min_inliers:\n",
        "        config = replace(config, min_inliers=6, min_cells=1)\n        if matches < config.min_inliers:\n",
    ),
    Mutant(
        "landmarks stay in the frame of the camera",
        "landmarks.py",
        "return Landmarks(transform(camera.T_B_C, _points(theta[good])), ids[good])",
        "return Landmarks(_points(theta[good]), ids[good])",
    ),
    Mutant(
        "bright pixels overflow when the image is amplified",
        "perception.py",
        "encoder.encode_image(seen)",
        "encoder.encode_image(2 * seen)",
    ),
    Mutant(
        "images are brightened for dark rooms",
        "perception.py",
        "encoder.encode_image(seen)",
        "encoder.encode_image(np.minimum(2.0 * seen, 255.0).astype(np.uint8))",
    ),
    Mutant(
        "the embedding of a percept is kept without a copy",
        "perception.py",
        "return seen.embedding.astype(np.float32)",
        "return seen.embedding",
    ),
)
