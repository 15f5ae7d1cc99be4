"""The size of a scenario, by which the search for the smallest failing scenario compares scenarios."""

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from shapely.geometry import Polygon

from sim.harness.run_settings import listed_house
from sim.harness.scenario import Scenario
from sim.harness.shrinking.house_edits import rooms_of
from sim.harness.shrinking.house_reductions import opening_rank
from sim.render.rig import RIGS
from sim.wording import counted
from worlds.labels import ROOM_LABELS
from worlds.stairs.cells import cell_on

PLAIN_MOTION: Mapping[str, Any] = MappingProxyType(
    {"sway": "none", "start_manoeuvre": False, "tour_kind": "rooms", "reverse": False}
)
"""The simplest motion, as fields of a scenario."""


class ScenarioSize(NamedTuple):
    """The size of a scenario. Sizes are compared as tuples, so the first entry is the most important one."""

    storeys: int
    rooms: int
    """Number of rooms. A staircase is one room, however many storeys it joins."""
    openings: int
    furniture: int
    windows: int
    faults: int
    drift: int
    """Number of kinds of odometry error, 0 to 2: poses that drift, and covariances that are too small."""
    motion: int
    """Number of complications of the motion: sway, start manoeuvre, a reversed tour, a kind of tour other than "rooms"."""
    length_m: float
    """Requested length of the tour [m]; infinite if the kind of tour decides."""
    corners: int
    area_m2: float
    opening_ranks: int
    """Sum of `opening_rank` over all openings: 0 if all openings are doorways without door leaves."""
    labels: int
    """Sum of the rooms' label indices in `ROOM_LABELS`, where simple labels come first."""
    appearance: int
    """Number of unusual looks: lighting other than daylight, and textures that are not rich."""
    frame_rate_hz: float
    rig: tuple[int, int, int]
    """Index of the rig in `RIGS`, 1 if the rig is displaced on the body (else 0), and number of pixels of an image."""

    def __str__(self) -> str:
        walk = f"{self.length_m:g} m" if math.isfinite(self.length_m) else "whole tour"
        return f"{counted(self.rooms, 'room')}, {walk}"


def size(scenario: Scenario) -> ScenarioSize:
    """Compute the size of a scenario. Raises `SimError` unless it lists its whole house; see `with_listed_house`."""
    spec = listed_house(scenario)
    rooms = [room for storey in spec.storeys for room in storey.rooms]
    openings = [opening for storey in spec.storeys for opening in storey.openings]
    rig = scenario.rig
    return ScenarioSize(
        storeys=len(spec.storeys),
        rooms=sum(cell_on(spec, level - 1, room) is None for level, room in rooms_of(spec, stairs=True)),
        openings=len(openings),
        furniture=sum(len(storey.furniture or ()) for storey in spec.storeys),
        windows=sum(len(storey.windows or ()) for storey in spec.storeys),
        faults=len(scenario.faults),
        drift=(scenario.odometry != "perfect") + (scenario.overconfidence > 1.0),
        motion=sum(getattr(scenario, name) != usual for name, usual in PLAIN_MOTION.items()),
        length_m=math.inf if scenario.length_m is None else scenario.length_m,
        corners=sum(len(room.polygon_m) for room in rooms),
        area_m2=round(sum(Polygon(room.polygon_m).area for room in rooms), 6),
        opening_ranks=sum(map(opening_rank, openings)),
        labels=sum(ROOM_LABELS.index(room.label) for room in rooms),
        appearance=(spec.appearance.light != "day") + (spec.appearance.texture != "rich"),
        frame_rate_hz=scenario.frame_rate_hz,
        rig=(list(RIGS).index(rig.name), int(any(rig.lever_arm_m + rig.lever_arm_rpy_deg)), rig.width * rig.height),
    )
