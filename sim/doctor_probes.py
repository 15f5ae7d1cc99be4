"""Checks that `sim.doctor` runs in child processes, because a broken driver or library may crash the process.

`python -m sim.doctor_probes draw encode` runs two checks in one process and prints the result of the last one.
"""

import sys
from collections.abc import Callable

from lexis.errors import LexisError
from sim.errors import GraphicsError, SimError

_SCENE = '<mujoco><worldbody><light pos="0 0 3"/><geom size=".3 .3 .3" type="box"/></worldbody></mujoco>'


def draw() -> str:
    """Render a box off-screen; return a text that names GL back end and device. Raises `GraphicsError` if this fails."""
    from sim.render.gl import choose_backend, device_name, graphics_errors, mujoco, require_rendering

    require_rendering()
    model = mujoco.MjModel.from_xml_string(_SCENE)
    with graphics_errors("a test image"), mujoco.Renderer(model, 48, 64) as renderer:
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        renderer.update_scene(data)
        if renderer.render().std() == 0.0:
            raise GraphicsError(
                f"{choose_backend()} renders an image of one colour only; update its driver or try another MUJOCO_GL"
            )
        return f"{choose_backend() or 'OpenGL of this system'} renders on {device_name()}"


def detect() -> str:
    """Find key points in an image of noise; return their number as text.

    Raises `LexisError` if OpenCV has no AKAZE, and `SimError` if it finds no key point.
    """
    import numpy as np

    from lexis.config import LandmarkConfig
    from lexis.features import OPENCV, FeatureExtractor

    image = np.random.default_rng(0).integers(0, 256, (96, 128, 3), np.uint8)
    found = len(FeatureExtractor(LandmarkConfig()).extract(image).keypoints)
    if not found:
        raise SimError(f"OpenCV finds no key point in an image of noise; valid: '{OPENCV}'")
    return f"{found} in an image of noise"


def encode() -> str:
    """Encode an image with the shipped encoder; return the embedding's size as text. Raises `LexisError` if this fails."""
    import numpy as np

    from lexis.encoder.open_clip_encoder import load_encoder

    embedding = load_encoder("mini").encode_image(np.zeros((96, 128, 3), np.uint8))
    return f"{embedding.shape[0]} dimensions"


PROBES: dict[str, Callable[[], str]] = {"draw": draw, "detect": detect, "encode": encode}


def main(names: list[str]) -> int:
    """Run the named checks in this process, in the given order, and return the exit status.

    Prints the result of the last check, or the error of the first check that fails.
    """
    try:
        found = [PROBES[name]() for name in names]
    except (SimError, LexisError) as error:
        print(error, file=sys.stderr)
        return 1
    print(found[-1])
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
