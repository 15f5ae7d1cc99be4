"""What a run consists of: a house, a walk, a drift, an encoder."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from lexis.config import Config
from lexis.types import Camera
from sim.errors import SimError
from sim.faults import Fault
from sim.faults.images import ImageFault, Smear
from sim.faults.world import ClosedDoors, Pedestrian
from sim.fidelity import FIDELITIES, ORACLE
from sim.odometry.config import ODOMETRY_PRESETS
from sim.odometry.simulation import OdometryConfig
from sim.render.rig import Rig, make_rig
from sim.tours.tour import TourConfig
from worlds.presets import sample_house
from worlds.spec import HouseSpec
from worlds.valid_names import did_you_mean

NEEDS_PIXELS = (ImageFault, Smear, ClosedDoors, Pedestrian)
"""Faults that the feature sensor knows nothing of: it has no pixels, and sees nothing that moves by itself."""
TOUR_LENGTH_M = {"home": 140.0}
"""Walks of presets that are shorter than two laps [m]."""


@dataclass(frozen=True)
class RunConfig:
    """One run of the harness. The same config gives the same result, apart from times."""

    preset: str = "home"
    """Family of houses; ignored where `house` is given."""
    seed: int = 7
    """Of the house (unless given), the tour, the odometry and the faults, each with a stream of its own."""
    house: HouseSpec | None = None
    """A house of one's own."""
    length_m: float | None = None
    """Wished length of the walk [m]; at least once through every room. None: the preset's, or as the kind has it."""
    tour_kind: str = "rooms"
    """Where the walk goes: one of `sim.tours.config.TOUR_KINDS`."""
    frame_rate_hz: float = 10.0
    """Observations a second; less than two a keyframe leaves no landmarks."""
    sway: str = "none"
    """How the body swings as it walks: one of `sim.tours.sway.SWAYS`."""
    start_manoeuvre: bool = False
    """Whether the body swings on the spot for five seconds before it walks."""
    odometry: str = "multicam"
    """How the odometry drifts: a key of `sim.odometry.ODOMETRY_PRESETS`."""
    overconfidence: float = 1.0
    """Factor by which the odometry's covariances are too small; 1 is honest."""
    encoder: str = "mini"
    """As `lexis.encoder.open_clip_encoder.load_encoder` takes it; or, with features, `ORACLE`."""
    fidelity: str = "render"
    """render: LEXIS is given images. features: what a model of the encoder makes of what is truly in view."""
    feature_model: Path | None = None
    """Fitted to the encoder by `lexis-sim fit-features`; None: the one that ships for `mini`."""
    loops: bool = True
    """Whether loops are closed."""
    refine: bool = True
    """Whether labels are refined."""
    faults: tuple[Fault, ...] = ()
    """What breaks, in order; see `sim.faults`."""
    lexis: Config = field(default_factory=Config)
    rig: Rig = field(default_factory=lambda: make_rig("wide"))
    """Cameras on the body. LEXIS sees the first pinhole's images; recordings have those of all pinholes."""

    def __post_init__(self) -> None:
        """Raise SimError for an unknown odometry preset or a negative seed."""
        if self.odometry not in ODOMETRY_PRESETS:
            valid = ", ".join(ODOMETRY_PRESETS)
            raise SimError(
                f"unknown odometry {self.odometry!r}{did_you_mean(self.odometry, ODOMETRY_PRESETS)}; valid: {valid}"
            )
        self.drift()
        self._check_fidelity()
        if not 0 <= self.seed < 2**63:
            raise SimError(f"seed {self.seed} is not in 0 ... 2**63 - 1")

    def _check_fidelity(self) -> None:
        if self.fidelity not in FIDELITIES:
            raise SimError(f"unknown fidelity {self.fidelity!r}; valid: {', '.join(FIDELITIES)}")
        if self.fidelity == "render":
            if self.encoder == ORACLE:
                raise SimError(f"encoder {ORACLE!r} is told the truth and sees no images; valid: with fidelity 'features'")
            return
        if unseen := [fault.name for fault in self.faults if isinstance(fault, NEEDS_PIXELS)]:
            raise SimError(f"fault {unseen[0]!r} is seen in images only; valid: with fidelity 'render'")

    @property
    def camera(self) -> Camera:
        """The camera of LEXIS."""
        return self.rig.front

    def house_spec(self) -> HouseSpec:
        """The given house, or the preset's house of this seed. Raises `worlds.errors.WorldsError`."""
        return self.house or sample_house(self.preset, self.seed)

    def tour(self) -> TourConfig:
        """How the walk goes."""
        usual = TOUR_LENGTH_M.get(self.preset) if self.house is None and self.tour_kind == "rooms" else None
        length_m = self.length_m if self.length_m is not None else usual
        return TourConfig(
            self.tour_kind,
            length_m,
            frame_rate_hz=self.frame_rate_hz,
            sway=self.sway,
            start_manoeuvre=self.start_manoeuvre,
        )

    def drift(self) -> OdometryConfig:
        """How the odometry drifts. Raises `SimError` for an overconfidence below 1."""
        return replace(ODOMETRY_PRESETS[self.odometry], overconfidence=self.overconfidence)

    def streams(self) -> dict[str, np.random.Generator]:
        """One generator per stage, so that a change to one stage leaves the others' draws alone."""
        tour, odometry = np.random.SeedSequence(self.seed).spawn(2)
        return {"tour": np.random.default_rng(tour), "odometry": np.random.default_rng(odometry)}

    def slam_config(self) -> Config:
        """The SLAM's settings with the run's switches applied."""
        config = self.lexis
        if not self.loops:
            config = replace(config, place_recognition=replace(config.place_recognition, candidates=0))
        if not self.refine:
            config = replace(config, labels=replace(config.labels, refine=False))
        return config
