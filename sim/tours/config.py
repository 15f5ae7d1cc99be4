"""Settings of a tour: its route, and the motion of the walker along that route."""

from dataclasses import dataclass
from typing import Annotated, Literal, get_args

from annotated_types import Ge, Gt

from lexis.settings import Settings
from sim.errors import SimError
from sim.tours.pace import Limits
from sim.tours.sway import SwayName

TourKind = Literal["rooms", "both ways", "loop", "random", "lawn-mower"]
TOUR_KINDS: tuple[TourKind, ...] = get_args(TourKind)
LONGEST_M, FASTEST_HZ = 100_000.0, 120.0
"""The longest tour [m] and the largest number of observations per second [Hz] that a scenario or a command may ask for. More
would not fit in memory."""


@dataclass(frozen=True)
class TourConfig(Settings, place="tour", error=SimError):
    """Settings of a tour: its kind and length, and the speeds, turn rates and gait of the walker."""

    kind: TourKind = "rooms"
    """Kind of tour. `rooms` goes through every room, the lowest storey first, and then once more through the lowest storey.
    `both ways` goes through every room and back along the same path. `loop` repeats one circuit several times. `random` goes
    between random places. `lawn-mower` goes through every room in parallel lanes."""
    length_m: Annotated[float, Gt(0)] | None = None
    """Requested length of the path [m]. The tour leaves out or repeats stops or lanes, so that its length is right to 3 m or
    3 %, whichever is more. None stands for the usual length of this kind of tour in this house."""
    circuit_m: Annotated[float, Ge(2)] | None = None
    """Length of one lap of a `loop` tour [m], 2 m or more: on a shorter lap, the body would turn on the spot. None stands
    for 40 m, or less in a small house."""
    laps: Annotated[int, Ge(1)] = 3
    """Number of laps of a `loop` tour if no length is requested."""
    reverse: bool = False
    """Whether the path is walked from its end to its start. The camera looks ahead in this case, too."""
    lane_m: Annotated[float, Ge(0.3)] = 1.0
    """Distance between the lanes of a `lawn-mower` tour [m]. It is increased if `length_m` is too short for it."""
    frame_rate_hz: Annotated[float, Gt(0)] = 10.0
    """Images per second [Hz]."""
    speed_m_s: Annotated[float, Gt(0)] = 0.7
    """Largest speed of the body [m/s]."""
    turn_rate_rad_s: Annotated[float, Gt(0)] = 1.2
    """Largest turn rate of the body [rad/s]."""
    acceleration_m_s2: Annotated[float, Gt(0)] = 1.5
    """Largest acceleration of the body [m/s²]."""
    eye_height_m: Annotated[float, Gt(0)] = 1.4
    """Height of the body frame above the walked surface [m]."""
    glance_rad: float = 0.3
    """Largest angle by which the camera turns away from the path [rad]. In rooms, it looks once to each side in 4 m."""
    pitch_on_stairs: bool = False
    """Whether the camera pitches with the slope of stairs. If False, the camera stays level."""
    sway: SwayName = "none"
    """Kind of gait whose periodic movements are added to the motion. The movements fade out where the body stands still."""
    start_manoeuvre: bool = False
    """Whether the body swings on the spot for five seconds first, so that visual-inertial systems can initialise."""
    prefer_clearance_m: float = 0.6
    """Distance kept from obstacles if there is enough free space [m]."""

    @property
    def limits(self) -> Limits:
        """The limits of speed, acceleration and turn rate."""
        return Limits(self.speed_m_s, self.acceleration_m_s2, self.turn_rate_rad_s)
