"""`TourConfig`: where a tour goes and how it is walked."""

from dataclasses import dataclass

import numpy as np

from sim.errors import SimError
from sim.tours.pace import Limits
from sim.tours.sway import SWAYS

TOUR_KINDS = ("rooms", "both ways", "loop", "random", "lawn-mower")

_POSITIVE = ("frame_rate_hz", "speed_m_s", "turn_rate_rad_s", "acceleration_m_s2", "eye_height_m", "lane_m")


@dataclass(frozen=True)
class TourConfig:
    """How the tour is walked. Raises `SimError` for values that no walk can have."""

    kind: str = "rooms"
    """rooms: every room, lowest storey first, then the lowest storey again in the same direction. both ways: every room
    and the same way back. loop: a circuit, several times. random: between random places. lawn-mower: every room in lanes."""
    length_m: float | None = None
    """Wished length [m], met within 3 m or 3 %: stops or lanes are left out, or gone through again, to meet it. None:
    as the kind has it."""
    circuit_m: float | None = None
    """Length of the loop's circuit [m]. None: 40, or less in a small house."""
    laps: int = 3
    """Of the loop, where no length is asked for."""
    lane_m: float = 1.0
    """Between the lawn-mower's lanes; wider where the asked length is too short for so many [m]."""
    frame_rate_hz: float = 10.0
    speed_m_s: float = 0.7
    """Largest, as are the next two: all kept at every time."""
    turn_rate_rad_s: float = 1.2
    acceleration_m_s2: float = 1.5
    eye_height_m: float = 1.4
    """Of the body frame above the walked surface."""
    glance_rad: float = 0.3
    """How far the view turns to either side of the way, about once in 4 m, in rooms."""
    pitch_on_stairs: bool = False
    """Whether the view goes up and down with the stairs. Otherwise it stays level."""
    sway: str = "none"
    """What the body's own gait adds; it fades where the body stands."""
    start_manoeuvre: bool = False
    """Whether the body swings on the spot for five seconds before it walks, for visual-inertial systems to initialise."""
    prefer_clearance_m: float = 0.6
    """Kept from obstacles where there is room."""

    def __post_init__(self) -> None:
        for name in _POSITIVE:
            if not 0.0 < (value := getattr(self, name)) < np.inf:
                raise SimError(f"tour: {name} is {value}; valid: positive and finite")
        for name in ("length_m", "circuit_m"):
            if (length := getattr(self, name)) is not None and not 0.0 < length < np.inf:
                raise SimError(f"tour: {name} is {length}; valid: positive and finite, or None")
        for name, valid in (("kind", TOUR_KINDS), ("sway", SWAYS)):
            if getattr(self, name) not in valid:
                raise SimError(f"tour: {name} is {getattr(self, name)!r}; valid: {', '.join(valid)}")
        if self.laps < 1 or self.lane_m < 0.3:
            raise SimError(f"tour: laps is {self.laps}, lane_m {self.lane_m}; valid: at least 1, at least 0.3")

    @property
    def limits(self) -> Limits:
        """What the walker keeps."""
        return Limits(self.speed_m_s, self.acceleration_m_s2, self.turn_rate_rad_s)
