"""The runs that encoders are measured on: walks through test houses, keyframe by keyframe, with what is true of them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float64, Int, UInt8

from lexis.config import KeyframeConfig
from lexis.types import Poses
from sim.harness.config import RunConfig
from sim.harness.parts import tour_config
from sim.harness.walk import walk
from sim.training.array_cache import Arrays, cached_arrays, house_origin, origin
from sim.training.frames import Frames, frames_at, frames_origin
from sim.training.houses import HELD_OUT_LOOKS, HouseDraw
from sim.training.variants import repainted
from sim.training.viewpoints import LEXIS_VIEWS, evenly_along
from worlds.house import House, build_house
from worlds.truth import room_at

TRAINED_LOOKS = tuple((HELD_OUT_LOOKS[i][0], HELD_OUT_LOOKS[1 - i][1]) for i in (0, 1))
"""The same textures and lights as in `HELD_OUT_LOOKS`, but in pairs that do meet in training."""
_MOST = 400
_LOOKED_AT = 60
"""Keyframes that are rendered once more in every look."""


@dataclass(frozen=True, eq=False)
class EncoderRun:
    """One walk through one house."""

    draw: HouseDraw
    stamps: Float64[np.ndarray, "n"]
    """Of the keyframes [s]."""
    room: Int[np.ndarray, "n"]
    """Index into the house's rooms of the one that holds the camera."""
    frames: Frames
    looked_at: Int[np.ndarray, "k"]
    """Keyframes that there are other looks of."""
    held_out_looks: UInt8[np.ndarray, "looks k h w 3"]
    """Their images where texture and light meet as they never do in training."""
    trained_looks: UInt8[np.ndarray, "looks k h w 3"]
    """And in pairs of the same textures and lights that do."""
    held_out_variants: UInt8[np.ndarray, "1 k h w 3"]
    """With furniture in colours that are never trained on."""
    trained_variants: UInt8[np.ndarray, "1 k h w 3"]
    """And with furniture in trained colours alone."""

    @property
    def T_W_B(self) -> Poses:
        """True poses of the keyframes."""
        return self.frames.T_W_B

    @property
    def house(self) -> House:
        """Built anew: the walk does not keep it."""
        return build_house(self.draw.spec())


_OWN = tuple(f.name for f in fields(EncoderRun) if f.name not in ("draw", "frames"))
"""What is kept of a run beside its frames; what it is drawn from is known."""


def encoder_runs(preset: str, seeds: Sequence[int], folder: Path | None = None) -> Iterator[EncoderRun]:
    """Walks as `lexis-sim run` takes them, one by one.

    Keyframes are as far apart as LEXIS's, or as evenly as 400 can be on longer walks. With a `folder`, frames that lie there
    are taken from it and others are left in it. Raises `SimError` for files in it that cannot be read, or were made of other
    houses or in another way.
    """
    for seed in seeds:
        draw = HouseDraw(preset, seed)
        if folder is None:
            yield _rendered(draw)
        else:
            yield _run(draw, cached_arrays(folder / f"{preset}-{seed}.npz", _origins(draw), partial(_rendered_arrays, draw)))


def keyframes_along(positions: Float64[np.ndarray, "n 3"]) -> Int[np.ndarray, "k"]:
    """Indices of frames a keyframe's spacing of path apart, or farther where that would be more than 400."""
    return evenly_along(positions, KeyframeConfig().spacing_m, _MOST)


def _rendered(draw: HouseDraw) -> EncoderRun:
    walked = walk(RunConfig(preset=draw.preset, seed=draw.seed))
    cached_arrays = keyframes_along(walked.tour.T_W_B[:, :3, 3])
    T_W_B = walked.tour.T_W_B[cached_arrays]
    some = np.unique(np.linspace(0, len(cached_arrays) - 1, _LOOKED_AT).astype(int))
    return EncoderRun(
        draw,
        walked.tour.stamps[cached_arrays],
        room_at(walked.house, T_W_B[:, :3, 3]),
        frames_at(walked.house, T_W_B, LEXIS_VIEWS),
        some,
        *(_in_looks(draw, looks, T_W_B[some]) for looks in (HELD_OUT_LOOKS, TRAINED_LOOKS)),
        *(frames_at(repainted(walked.house, held_out), T_W_B[some], LEXIS_VIEWS).images[None] for held_out in (True, False)),
    )


def _in_looks(draw: HouseDraw, looks: Sequence[tuple[Any, Any]], T_W_B: Poses) -> UInt8[np.ndarray, "looks k h w 3"]:
    houses = (build_house(draw._replace(texture=texture, light=light).spec()) for texture, light in looks)
    return np.stack([frames_at(house, T_W_B, LEXIS_VIEWS).images for house in houses])


def _origins(draw: HouseDraw) -> tuple[str, str]:
    chosen = (tour_config(RunConfig(preset=draw.preset, seed=draw.seed)), KeyframeConfig().spacing_m, _MOST, _LOOKED_AT)
    own = (HELD_OUT_LOOKS, TRAINED_LOOKS, [f.name for f in fields(EncoderRun)])
    return origin(frames_origin(LEXIS_VIEWS), chosen, own), house_origin(draw)


def _rendered_arrays(draw: HouseDraw) -> Arrays:
    run = _rendered(draw)
    own = {name: getattr(run, name) for name in _OWN}
    return own | {f"frames.{name}": values for name, values in run.frames.arrays.items()}


def _run(draw: HouseDraw, arrays: Arrays) -> EncoderRun:
    frames = Frames(*(arrays[f"frames.{f.name}"] for f in fields(Frames)))
    return EncoderRun(draw=draw, frames=frames, **{name: arrays[name] for name in _OWN})
