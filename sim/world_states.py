"""`WorldStates`: the house and the moving actors at every frame of a tour. Faults of the world may change them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from jaxtyping import Float32, Float64
from numpy import ndarray

from lexis.types import Camera, Image
from sim.faults import Fault, WorldFault, WorldState, fault_rng
from sim.render.actor import Actor
from sim.render.camera import CameraRenderer, fovy_deg
from sim.render.lens import Distortion, Lens, rendered_camera
from sim.render.scene import Scene, build_scene
from sim.tours.tour import Tour
from sim.truth import Truth
from worlds.house import House
from worlds.visuals.meshes import Solid


@dataclass(frozen=True, eq=False)
class CompiledHouse:
    """A house and the scene that is compiled from it for the cameras of a rig, without actors (people and moving doors)."""

    house: House
    camera: Camera

    @cached_property
    def scene(self) -> Scene:
        """The house as a MuJoCo scene, ready to render. It is compiled at the first access."""
        images = [camera.intrinsics for camera in self.camera.rig]
        size_px = max(k.width for k in images), max(k.height for k in images)
        return build_scene(self.house, size_px, fovy_deg(self.camera.intrinsics))


@dataclass(frozen=True, eq=False)
class RenderableWorld:
    """A static house and the actors (people and doors) that move in it."""

    compiled: CompiledHouse
    actors: tuple[Actor, ...]

    @property
    def scene(self) -> Scene:
        """The compiled scene of the house, without the actors."""
        return self.compiled.scene


class WorldStates:
    """The worlds (house and moving actors) of a tour: one for each set of faults of the world that are active together.

    Without faults of the world there is a single world.
    """

    def __init__(self, house: House, tour: Tour, camera: Camera, faults: Sequence[Fault], seed: int) -> None:
        world = [(place, fault) for place, fault in enumerate(faults) if isinstance(fault, WorldFault)]
        spans = [fault.span_s(tour) for _, fault in world]
        self._stamps = tour.stamps
        self.active = [
            tuple(k for k, (start, end) in enumerate(spans) if start <= stamp < end) for stamp in tour.stamps.tolist()
        ]
        """Numbers of the world faults that are active at each frame; 0 is the first world fault of the run."""
        self._names = [fault.name for _, fault in world]
        self._sets: dict[tuple[int, ...], RenderableWorld] = {}
        houses: dict[int, CompiledHouse] = {}
        for active in dict.fromkeys(self.active):
            state = WorldState(house)
            for place, fault in (world[k] for k in active):
                state = fault.change(state, tour, fault_rng(seed, place))
            compiled = houses.setdefault(id(state.house), CompiledHouse(state.house, camera))
            self._sets[active] = RenderableWorld(compiled, state.actors)

    @property
    def houses(self) -> list[House]:
        """The house at each frame. Frames at which the same faults of the world are active share one `House` object."""
        return [self._sets[active].compiled.house for active in self.active]

    def compile(self) -> None:
        """Compile all scenes now, so that no frame has to wait for its scene."""
        for each in self._sets.values():
            each.scene  # noqa: B018

    def world_at(self, frame: int) -> RenderableWorld:
        """Return the world that is rendered at a frame of the tour."""
        return self._sets[self.active[frame]]

    def solids_at(self, frame: int, T_W_B: Float64[ndarray, "4 4"]) -> list[Solid]:
        """Return the shapes of all actors at a frame. Some depend on the body's pose `T_W_B`: doors open near the body."""
        stamp = float(self._stamps[frame])
        return [solid for actor in self.world_at(frame).actors for solid in actor.solids_at(stamp, T_W_B)]

    def marked(self, truths: Sequence[Truth]) -> tuple[Truth, ...]:
        """Return copies of the truths of all frames, in which the names of the active world faults are recorded."""
        return tuple(
            replace(truth, faults=tuple(self._names[k] for k in active)) if active else truth
            for truth, active in zip(truths, self.active, strict=True)
        )


class FrameRenderer:
    """Renders the frames of a tour, each in its own world. Use it in one thread at a time.

    With a distortion, `world_states` has to be built for the larger pinhole camera from `sim.render.lens.rendered_camera`.
    """

    def __init__(self, world_states: WorldStates, camera: Camera, distortion: Distortion | None = None) -> None:
        self._world_states = world_states
        self._lenses = [Lens(each.intrinsics, distortion) for each in camera.rig] if distortion else []
        self._camera = rendered_camera(camera, distortion) if distortion else camera
        self._renderer: CameraRenderer | None = None

    def rgb(self, frame: int, T_W_B: Float64[ndarray, "4 4"]) -> Image:
        """Render the image of a frame from a body pose. For a rig, this is the image of its first camera."""
        image = self._set(frame, T_W_B).rgb(T_W_B)
        return self._lenses[0].image(image) if self._lenses else image

    def rig(self, frame: int, T_W_B: Float64[ndarray, "4 4"]) -> tuple[Image, ...]:
        """Render the images of a frame by all cameras of the rig from a body pose."""
        images = self._set(frame, T_W_B).rig(T_W_B)
        if not self._lenses:
            return images
        return tuple(lens.image(image) for lens, image in zip(self._lenses, images, strict=True))

    def depth(self, frame: int, T_W_B: Float64[ndarray, "4 4"]) -> Float32[ndarray, "h w"]:
        """Render the depth of a frame along the optical axis [m]. It is never given to LEXIS."""
        depth = self._set(frame, T_W_B).depth(T_W_B)
        return self._lenses[0].nearest(depth) if self._lenses else depth

    def _set(self, frame: int, T_W_B: Float64[ndarray, "4 4"]) -> CameraRenderer:
        scene = self._world_states.world_at(frame).scene
        if self._renderer is None or self._renderer.scene is not scene:
            self.close()
            self._renderer = CameraRenderer(scene, self._camera)
        self._renderer.place(self._world_states.solids_at(frame, T_W_B))
        return self._renderer

    def close(self) -> None:
        """Release the GL context."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None
