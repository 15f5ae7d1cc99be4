"""The data to which feature models are fitted: views on walks through houses, with true content and embeddings."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Float64, Int

from lexis.perception import Encoder
from sim.feature_sensor.surroundings import Surroundings, survey
from sim.feature_sensor.visible_shares import VisibleShares, look
from sim.render.camera import CameraRenderer, fovy_deg, wide_camera
from sim.render.scene import build_scene
from sim.tours.tour import Tour, plan_tour
from sim.training.houses import HouseDraw
from worlds.house import House, build_house
from worlds.truth import room_at
from worlds.walkable import Walkable


@dataclass(frozen=True, eq=False)
class Sample:
    """Frames of a walk through one house: body poses, true contents of the views, and embeddings of the images."""

    around: Surroundings
    T_W_B: Float64[np.ndarray, "n 4 4"]
    views: VisibleShares
    embeddings: Float32[np.ndarray, "n d"]
    """Embeddings of the rendered images."""

    @property
    def true_labels(self) -> Int[np.ndarray, "n"]:
        """True label of every frame, as an index into the house's room labels."""
        house = self.around.house
        labels = house.spec.room_labels
        return np.array([labels.index(house.rooms[i].label) for i in room_at(house, self.T_W_B[:, :3, 3])], int)


def choices(houses: int, first_seed: int) -> tuple[HouseDraw, ...]:
    """Choose houses of various presets, openness and clutter. The seeds are consecutive, starting with `first_seed`."""
    presets = ("home", "random", "ori", "home", "office", "uh2-apt", "apartment", "home", "clinic", "uh2-office", "school")
    openness, clutter = (None, 0.2, None, 0.6, None), (1.0, 1.0, 0.3, 1.0, 2.0, 1.0, 0.0)
    return tuple(
        HouseDraw(
            presets[i % len(presets)],
            first_seed + i,
            openness=openness[i % len(openness)],
            clutter=clutter[i % len(clutter)],
        )
        for i in range(houses)
    )


def sample(choice: HouseDraw, encoder: Encoder, frames: int) -> Sample:
    """Render and encode up to `frames` frames, which are evenly spread over a tour through a house."""
    camera = wide_camera()
    house = build_house(choice.spec())
    tour = tour_through(house, choice.seed)
    poses = tour.T_W_B[np.unique(np.linspace(0, len(tour.stamps) - 1, frames).astype(int))]
    around = survey(house)
    k = camera.intrinsics
    scene = build_scene(house, (k.width, k.height), fovy_deg(k))
    with CameraRenderer(scene, camera) as renderer:
        embeddings = np.stack([encoder.encode_image(renderer.rgb(T_W_B)) for T_W_B in poses])
    return Sample(around, poses, look(around, poses, camera), embeddings)


def tour_through(house: House, seed: int) -> Tour:
    """Plan the tour that samples and benchmarks use in a house."""
    return plan_tour(house, Walkable(house), np.random.default_rng(seed))
