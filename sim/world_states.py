"""`WorldStates`: which world there is to see at every frame of a tour, under faults that change it on the way."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from jaxtyping import Float32, Float64
from numpy import ndarray

from lexis.types import Camera, Image
from sim.faults import Fault, WorldFault, WorldState, fault_rng
from sim.render.actor import Actor
from sim.render.camera import CameraRenderer, fovy_deg
from sim.render.lens import Distortion, Lens
from sim.render.scene import Scene, build_scene
from sim.tours.tour import Tour
from sim.truth import Truth
from worlds.house import House
from worlds.visuals.meshes import Solid


@dataclass(frozen=True, eq=False)
class CompiledHouse:
    """What stands in a world, whoever moves in it."""

    house: House
    camera: Camera

    @cached_property
    def scene(self) -> Scene:
        """Ready to render; compiled when it is first asked for."""
        k = self.camera.intrinsics
        return build_scene(self.house, (k.width, k.height), fovy_deg(k))


@dataclass(frozen=True, eq=False)
class RenderableWorld:
    """A world to look at."""

    stand: CompiledHouse
    actors: tuple[Actor, ...]

    @property
    def scene(self) -> Scene:
        """What stands in it, ready to render."""
        return self.stand.scene


class WorldStates:
    """The sets of a tour; a house without faults of the world has one."""

    def __init__(self, house: House, tour: Tour, camera: Camera, faults: Sequence[Fault], seed: int) -> None:
        world = [(place, fault) for place, fault in enumerate(faults) if isinstance(fault, WorldFault)]
        spans = [fault.span_s(tour) for _, fault in world]
        self._stamps = tour.stamps
        self.active = [
            tuple(k for k, (start, end) in enumerate(spans) if start <= stamp < end) for stamp in tour.stamps.tolist()
        ]
        """Per frame: which of the faults of the world are there."""
        self._names = [fault.name for _, fault in world]
        self._sets: dict[tuple[int, ...], RenderableWorld] = {}
        stands: dict[int, CompiledHouse] = {}
        for active in dict.fromkeys(self.active):
            stage = WorldState(house)
            for place, fault in (world[k] for k in active):
                stage = fault.change(stage, tour, fault_rng(seed, place))
            stand = stands.setdefault(id(stage.house), CompiledHouse(stage.house, camera))
            self._sets[active] = RenderableWorld(stand, stage.actors)

    @property
    def houses(self) -> list[House]:
        """Per frame: the house as it then is; the same object where it is the same."""
        return [self._sets[active].stand.house for active in self.active]

    def compile(self) -> None:
        """Make all scenes ready to render."""
        for each in self._sets.values():
            each.scene  # noqa: B018

    def set_at(self, frame: int) -> RenderableWorld:
        """What there is to see at a frame."""
        return self._sets[self.active[frame]]

    def solids_at(self, frame: int, T_W_B: Float64[ndarray, "4 4"]) -> list[Solid]:
        """What moves, as it stands at a frame."""
        stamp = float(self._stamps[frame])
        return [solid for actor in self.set_at(frame).actors for solid in actor.solids_at(stamp, T_W_B)]

    def marked(self, truths: Sequence[Truth]) -> tuple[Truth, ...]:
        """Truths of all frames with the faults of the world recorded in them."""
        return tuple(
            replace(truth, faults=tuple(self._names[k] for k in active)) if active else truth
            for truth, active in zip(truths, self.active, strict=True)
        )


class FrameRenderer:
    """Renders the frames of a tour, each in its set. Belongs to the thread that uses it, as the GL context does.

    With a distortion, the staging has to be made for `sim.render.lens.rendered_camera`, which is larger.
    """

    def __init__(self, staging: WorldStates, camera: Camera, distortion: Distortion | None = None) -> None:
        self._staging = staging
        self._lens = Lens(camera.intrinsics, distortion) if distortion else None
        self._camera = camera if self._lens is None else Camera(self._lens.pinhole, camera.T_B_C)
        self._renderer: CameraRenderer | None = None

    def rgb(self, frame: int, T_W_B: Float64[ndarray, "4 4"]) -> Image:
        """The image of a frame, seen from a pose of the body."""
        image = self._set(frame, T_W_B).rgb(T_W_B)
        return image if self._lens is None else self._lens.image(image)

    def depth(self, frame: int, T_W_B: Float64[ndarray, "4 4"]) -> Float32[ndarray, "h w"]:
        """Its depth along the optical axis [m]. It never reaches LEXIS."""
        depth = self._set(frame, T_W_B).depth(T_W_B)
        return depth if self._lens is None else self._lens.nearest(depth)

    def _set(self, frame: int, T_W_B: Float64[ndarray, "4 4"]) -> CameraRenderer:
        scene = self._staging.set_at(frame).scene
        if self._renderer is None or self._renderer.scene is not scene:
            self.close()
            self._renderer = CameraRenderer(scene, self._camera)
        self._renderer.place(self._staging.solids_at(frame, T_W_B))
        return self._renderer

    def close(self) -> None:
        """Release the GL context."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None
