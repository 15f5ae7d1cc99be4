"""Settings of one run: a house, a tour through it, odometry, faults, and LEXIS with its encoder."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from annotated_types import Ge, Gt, Interval

from lexis.config import Config
from lexis.settings import Settings
from sim.errors import SimError
from sim.faults import Fault
from sim.faults.images import ImageFault, Smear
from sim.faults.world import ClosedDoors, Pedestrian
from sim.fidelity import ORACLE, Fidelity
from sim.odometry.config import ODOMETRY_PRESETS
from sim.render.rig import Rig, make_rig
from sim.tours.config import TourKind
from sim.tours.sway import SwayName
from worlds.spec import HouseSpec
from worlds.valid_names import did_you_mean

NEEDS_PIXELS = (ImageFault, Smear, ClosedDoors, Pedestrian)
"""Faults that the feature sensor cannot represent, since it has no pixels and ignores what moves by itself."""


@dataclass(frozen=True)
class RunConfig(Settings, place="run", error=SimError):
    """One run of the harness. The same config gives the same result, apart from times."""

    preset: str = "home"
    """Family of houses; ignored if `house` is given."""
    seed: Annotated[int, Interval(ge=0, lt=2**63)] = 7
    """Seed of the house (unless given), the tour, the odometry and the faults; each has a random stream of its own."""
    house: HouseSpec | None = None
    """A house instead of the one that preset and seed describe."""
    length_m: Annotated[float, Gt(0)] | None = None
    """Requested length of the tour [m]. None: the length that is usual for the preset, or for the kind of tour."""
    tour_kind: TourKind = "rooms"
    """Where the tour goes; see `TourConfig.kind`."""
    frame_rate_hz: Annotated[float, Gt(0)] = 10.0
    """Observations per second [Hz]. Fewer than two per keyframe leave no landmarks."""
    sway: SwayName = "none"
    """The gait that is added to the motion; see `sim.tours.sway`."""
    start_manoeuvre: bool = False
    """Whether the body swings on the spot for five seconds before the tour."""
    odometry: str = "multicam"
    """How the odometry drifts: a key of `sim.odometry.ODOMETRY_PRESETS`."""
    overconfidence: Annotated[float, Ge(1)] = 1.0
    """Factor by which the odometry's covariances are too small; 1 is honest."""
    encoder: str = "mini"
    """Name of the encoder, as `lexis.load_encoder` takes it; with fidelity "features" also `ORACLE`."""
    fidelity: Fidelity = "render"
    """render: LEXIS gets images. features: LEXIS gets what the feature sensor predicts from the true view."""
    feature_model: Path | None = None
    """Feature model that `lexis-sim fit-features` has fitted to the encoder. None: the shipped one for `mini`."""
    loops: bool = True
    """Whether LEXIS closes loops."""
    refine: bool = True
    """Whether LEXIS refines labels."""
    faults: tuple[Fault, ...] = ()
    """Faults in the order in which they act; see `sim.faults`."""
    lexis: Config = field(default_factory=Config)
    """All other settings of LEXIS."""
    rig: Rig = field(default_factory=lambda: make_rig("wide"))
    """Cameras on the body. LEXIS gets the images of the first pinhole camera, recordings those of all of them."""

    def __post_init__(self) -> None:
        """Raise SimError for values that are not valid, alone or together."""
        super().__post_init__()
        if self.odometry not in ODOMETRY_PRESETS:
            guess = did_you_mean(self.odometry, ODOMETRY_PRESETS)
            raise SimError(f"unknown odometry {self.odometry!r}{guess}; valid: {', '.join(ODOMETRY_PRESETS)}")
        if self.fidelity == "render" and self.encoder == ORACLE:
            raise SimError(f"encoder {ORACLE!r} is told the truth and sees no images; valid: with fidelity 'features'")
        unseen = [fault.name for fault in self.faults if isinstance(fault, NEEDS_PIXELS)]
        if self.fidelity == "features" and unseen:
            raise SimError(f"fault {unseen[0]!r} is seen in images only; valid: with fidelity 'render'")
