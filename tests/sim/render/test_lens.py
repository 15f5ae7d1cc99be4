"""A lens distorts a pinhole image exactly as OpenCV's model does, and OpenCV's rectification removes the distortion."""

import cv2
import numpy as np
import pytest
from helpers.viewpoints import viewpoints

from sim.errors import SimError
from sim.render.camera import CameraRenderer, fovy_deg, wide_camera
from sim.render.lens import Distortion, Lens, rendered_camera
from sim.render.scene import build_scene
from worlds.house import build_house
from worlds.presets import sample_house

EUROC = Distortion(-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05)
DISTORTIONS = {
    "EuRoC": EUROC,
    "barrel": Distortion(-0.1, 0.008, 0.0005, -0.0003),
    "cushion": Distortion(0.05, -0.005),
    "tangential": Distortion(-0.1, 0.02, 0.01, -0.02),
}
QUARTERS = [np.s_[v : v + 70, u : u + 80] for v in (20, 90) for u in (40, 120)]
"""The middle of the image."""
CAMERA = wide_camera(240, 180)


@pytest.fixture(scope="module", params=DISTORTIONS.values(), ids=DISTORTIONS)
def distortion(request):
    return request.param


@pytest.fixture(scope="module")
def seen(distortion):
    """The lens, and the same views from several viewpoints through a pinhole and through the lens."""
    house = build_house(sample_house("uh2-apt", 3))
    wide, lens = rendered_camera(CAMERA, distortion), Lens(CAMERA.intrinsics, distortion)
    size = max(wide.intrinsics.width, 240), max(wide.intrinsics.height, 180)
    scene = build_scene(house, size, fovy_deg(CAMERA.intrinsics))
    places = viewpoints(house, 4, tilt=0.3)
    with CameraRenderer(scene, CAMERA) as plain, CameraRenderer(scene, wide) as wider:
        return [(plain.frame(T_W_B), wider.frame(T_W_B)) for T_W_B in places], lens


def grid(k):
    v, u = np.mgrid[: k.height, : k.width]
    return np.stack([u.ravel(), v.ravel()], axis=-1).astype(np.float64)


def blurred(image):
    return cv2.GaussianBlur(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), (0, 0), 1.5).astype(np.float32)


def test_points_are_bent_as_opencv_bends_them(distortion):
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (100, 2))
    rays = np.column_stack([points, np.ones(100)])
    theirs, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), np.eye(3), np.array(distortion.coefficients))
    np.testing.assert_allclose(distortion.distort(points), theirs[:, 0], atol=1e-12)
    np.testing.assert_allclose(distortion.undistort(distortion.distort(points)), points, atol=1e-8)


def test_rectified_by_opencv_it_is_the_pinhole_s_image(distortion, seen):
    """The images differ by the blur of two interpolations, and are shifted by less than a tenth of a pixel everywhere."""
    frames, lens = seen
    k = CAMERA.intrinsics
    known = cv2.undistort(np.full((180, 240), 255, np.uint8), k.matrix, np.array(distortion.coefficients)) == 255
    inside = cv2.erode(known.astype(np.uint8), np.ones((5, 5))).astype(bool)
    assert inside.mean() > 0.6
    for plain, wide in frames:
        bent = lens.image(wide.rgb)
        straight = cv2.undistort(bent, k.matrix, np.array(distortion.coefficients))
        error = np.abs(straight.astype(int) - plain.rgb)[inside]
        assert np.median(error) <= 1 and np.abs(bent.astype(int) - plain.rgb)[inside].mean() > 4 * error.mean()
        for quarter in QUARTERS:
            shift, _ = cv2.phaseCorrelate(blurred(straight)[quarter], blurred(plain.rgb)[quarter])
            assert np.abs(shift).max() < 0.1


def test_depth_and_ids_are_those_of_the_rays(distortion, seen):
    """The ray of a pixel, computed by OpenCV, hits the plane that the pinhole camera sees: exactly so, except at edges."""
    frames, lens = seen
    k = CAMERA.intrinsics
    coefficients = np.array(distortion.coefficients)
    for plain, wide in frames:
        depth, ids = lens.nearest(wide.depth), lens.nearest(wide.geom_ids)
        assert depth.shape == ids.shape == (180, 240) and depth.dtype == np.float32
        pixels = grid(k)
        straight = cv2.undistortPointsIter(
            pixels[:, None], k.matrix, coefficients, None, k.matrix, (cv2.TERM_CRITERIA_COUNT, 200, 0)
        )[:, 0]
        inside = ((straight > 1) & (straight < [k.width - 2, k.height - 2])).all(axis=1)
        u, v = np.rint(straight[inside]).astype(int).T
        assert (plain.geom_ids[v, u] == ids.ravel()[inside]).mean() > 0.98
        error = np.abs(plain.depth[v, u] - depth.ravel()[inside]) / depth.ravel()[inside]
        assert np.median(error) < 1e-5 and (error < 0.02).mean() > 0.97


def test_without_distortion_every_pixel_stays():
    lens = Lens(CAMERA.intrinsics, Distortion())
    k = lens.pinhole
    image = np.random.default_rng(0).integers(0, 256, (k.height, k.width, 3), np.uint8)
    kept = image[2:-2, 2:-2]
    assert kept.shape == (180, 240, 3) and (k.cx, k.cy) == (CAMERA.intrinsics.cx + 2, CAMERA.intrinsics.cy + 2)
    np.testing.assert_array_equal(lens.image(image), kept)
    np.testing.assert_array_equal(lens.nearest(image[..., 0]), kept[..., 0])
    assert not Distortion() and Distortion(p2=1e-3)


@pytest.mark.parametrize("coefficients", [(-0.5,), (-0.35, 0.0), (3.0, -3.0), (0.0, 0.0, 0.5, 0.0)])
def test_a_lens_that_folds_the_image_is_refused(coefficients):
    with pytest.raises(SimError, match=r"distortion: \(.*valid: weaker coefficients"):
        Lens(CAMERA.intrinsics, Distortion(*coefficients))


def test_coefficients_are_finite():
    with pytest.raises(SimError, match="valid: finite"):
        Distortion(float("nan"))
