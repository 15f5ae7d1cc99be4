"""The runs that encoders are measured on: keyframes along walks through test houses, with ground truth."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float64, Int, UInt8

from lexis.config import KeyframeConfig
from lexis.types import Poses
from sim.harness.run_settings import tour_config
from sim.harness.scenario import Scenario
from sim.harness.walk import walk
from sim.training.array_cache import Arrays, cached_arrays, house_origin, origin
from sim.training.frames import Frames, frames_at, frames_origin
from sim.training.houses import HELD_OUT_LOOKS, HouseDraw
from sim.training.variants import repainted
from sim.training.viewpoints import LEXIS_VIEWS, evenly_along
from worlds.house import House, build_house
from worlds.truth import room_at

TRAINED_LOOKS = tuple((HELD_OUT_LOOKS[i][0], HELD_OUT_LOOKS[1 - i][1]) for i in (0, 1))
"""Pairs of texture and lighting that occur in training, with the same textures and lightings as in `HELD_OUT_LOOKS`."""
_MOST = 400
"""Largest number of keyframes that are measured on one walk."""
_LOOKED_AT = 60
"""Number of keyframes of a walk that are rendered again with other textures, lightings and furniture colours."""


@dataclass(frozen=True, eq=False)
class EncoderRun:
    """The keyframes of one walk through one house."""

    draw: HouseDraw
    stamps: Float64[np.ndarray, "n"]
    """Time stamps of the keyframes [s]."""
    room: Int[np.ndarray, "n"]
    """For each keyframe, the room that contains the camera, as an index into the house's rooms."""
    frames: Frames
    looked_at: Int[np.ndarray, "k"]
    """Indices of the keyframes that were also rendered with other textures, lightings and furniture colours."""
    held_out_looks: UInt8[np.ndarray, "looks k h w 3"]
    """Images of the keyframes in `looked_at`, rendered with pairs of texture and lighting that never occur in training."""
    trained_looks: UInt8[np.ndarray, "looks k h w 3"]
    """Images of the keyframes `looked_at` with the same textures and lightings, but in pairs that occur in training."""
    held_out_variants: UInt8[np.ndarray, "1 k h w 3"]
    """Images of the keyframes `looked_at` with furniture in colours that never occur in training."""
    trained_variants: UInt8[np.ndarray, "1 k h w 3"]
    """Images of the keyframes `looked_at` with furniture only in colours that occur in training."""

    @property
    def T_W_B(self) -> Poses:
        """True poses of the keyframes."""
        return self.frames.T_W_B

    @property
    def house(self) -> House:
        """The house. It is built again at each access, since a run does not store it."""
        return build_house(self.draw.spec())


_OWN = tuple(f.name for f in fields(EncoderRun) if f.name not in ("draw", "frames"))
"""Fields of a run that are cached in addition to its frames. The `draw` is not cached, because the caller supplies it."""


def encoder_runs(preset: str, seeds: Sequence[int], folder: Path | None = None) -> Iterator[EncoderRun]:
    """Yield one run per seed, along the same walk that `lexis-sim run` takes.

    Keyframes are spaced as in LEXIS; on long walks they are farther apart, so that there are at most 400. If a `folder`
    is given, it is a cache: runs are loaded from it, and new ones are saved in it. Raises `SimError` if a file there cannot
    be read, or was made from other houses or with other settings.
    """
    for seed in seeds:
        draw = HouseDraw(preset, seed)
        if folder is None:
            yield _rendered(draw)
        else:
            yield _run(draw, cached_arrays(folder / f"{preset}-{seed}.npz", _origins(draw), partial(_rendered_arrays, draw)))


def keyframes_along(positions: Float64[np.ndarray, "n 3"]) -> Int[np.ndarray, "k"]:
    """Return indices of frames that are LEXIS's keyframe spacing apart along the path.

    On long paths, the frames are farther apart, so that there are at most 400.
    """
    return evenly_along(positions, KeyframeConfig().spacing_m, _MOST)


def _rendered(draw: HouseDraw) -> EncoderRun:
    walked = walk(Scenario(preset=draw.preset, seed=draw.seed))
    keyframes = keyframes_along(walked.tour.T_W_B[:, :3, 3])
    T_W_B = walked.tour.T_W_B[keyframes]
    some = np.unique(np.linspace(0, len(keyframes) - 1, _LOOKED_AT).astype(int))
    return EncoderRun(
        draw,
        walked.tour.stamps[keyframes],
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
    chosen = (tour_config(Scenario(preset=draw.preset, seed=draw.seed)), KeyframeConfig().spacing_m, _MOST, _LOOKED_AT)
    own = (HELD_OUT_LOOKS, TRAINED_LOOKS, [f.name for f in fields(EncoderRun)])
    return origin(frames_origin(LEXIS_VIEWS), chosen, own), house_origin(draw)


def _rendered_arrays(draw: HouseDraw) -> Arrays:
    run = _rendered(draw)
    own = {name: getattr(run, name) for name in _OWN}
    return own | {f"frames.{name}": values for name, values in run.frames.arrays.items()}


def _run(draw: HouseDraw, arrays: Arrays) -> EncoderRun:
    frames = Frames(*(arrays[f"frames.{f.name}"] for f in fields(Frames)))
    return EncoderRun(draw=draw, frames=frames, **{name: arrays[name] for name in _OWN})
