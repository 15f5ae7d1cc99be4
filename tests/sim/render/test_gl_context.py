"""GL contexts: however a renderer ends, the images of the others stay as they are."""

import gc
import threading
import time

import numpy as np
import pytest
from helpers.viewpoints import viewpoints

from sim.render.camera import CameraRenderer, fovy_deg, wide_camera
from sim.render.gl_context import GlContext
from sim.render.scene import build_scene
from worlds.house import build_house
from worlds.presets import sample_house

CAMERA = wide_camera(160, 120)


@pytest.fixture(scope="module")
def house():
    return build_house(sample_house("uh2-apt", 3))


@pytest.fixture(scope="module")
def scene(house):
    return build_scene(house, (160, 120), fovy_deg(CAMERA.intrinsics))


@pytest.fixture(scope="module")
def poses(house):
    return viewpoints(house, 3)


@pytest.fixture
def other(scene, poses):
    """A renderer that gives the same images at the end of a test as at its start."""
    with CameraRenderer(scene, CAMERA) as other:
        before = [other.rgb(T) for T in poses]
        yield other
        gc.collect()
        for T, image in zip(poses, before, strict=True):
            np.testing.assert_array_equal(other.rgb(T), image)


@pytest.fixture
def thread(scene, poses):
    """A thread that has rendered, and lives until it may end; and a list that holds its renderer."""
    box, has_rendered, may_end = [], threading.Event(), threading.Event()

    def render():
        box.append(CameraRenderer(scene, CAMERA))
        box[0].rgb(poses[0])
        has_rendered.set()
        may_end.wait()

    thread = threading.Thread(target=render)
    thread.start()
    has_rendered.wait()
    yield thread, box, may_end
    may_end.set()
    thread.join()


@pytest.mark.parametrize("closes", [True, False])
def test_a_renderer_may_end_while_another_one_draws(other, scene, poses, closes):
    ending = CameraRenderer(scene, CAMERA)
    ending.rgb(poses[0])
    other.rgb(poses[1])
    if closes:
        ending.close()
    del ending
    gc.collect()


@pytest.mark.usefixtures("other")
@pytest.mark.parametrize("closes", [True, False])
def test_a_renderer_may_end_in_a_thread_that_did_not_make_it(thread, closes):
    """The garbage collector closes abandoned renderers in any thread."""
    thread, box, may_end = thread
    may_end.set()
    thread.join()
    if closes:
        box[0].close()
    box.clear()
    gc.collect()


@pytest.mark.usefixtures("other")
@pytest.mark.parametrize("closes", [True, False])
def test_a_renderer_may_end_in_another_thread_than_the_one_that_renders(thread, closes):
    _, box, _ = thread
    if closes:
        box[0].close()
    box.clear()
    gc.collect()


def test_only_one_thread_draws_at_a_time(scene):
    events = []
    first, second = GlContext(scene.model), GlContext(scene.model)

    def draw_in_second():
        with second.as_current():
            events.append("second begins")

    with first.as_current():
        other = threading.Thread(target=draw_in_second)
        other.start()
        time.sleep(0.05)  # without a lock, the other thread begins in this time
        events.append("first ends")
    other.join()
    assert events == ["first ends", "second begins"]
    for context in (first, second):
        context.close()
