"""`Scenario`: all settings that determine a run, as one value with a JSON form and a content hash."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Annotated, Any

from annotated_types import Ge, Interval

from lexis.files.reading import FileKind, read_json
from lexis.files.replace import replaced_file
from lexis.settings import Settings, settings_data, settings_of
from sim.errors import SimError
from sim.faults import FAULTS, Fault
from sim.faults.images import OF_IMAGES
from sim.faults.world import ClosedDoors, Pedestrian
from sim.fidelity import ENCODERS_ON_FEATURES, ORACLE, Fidelity, may_be_imitated
from sim.odometry.config import ODOMETRY_PRESETS
from sim.render.rig import RigConfig
from sim.tours.config import FASTEST_HZ, LONGEST_M, TourKind
from sim.tours.sway import SwayName
from worlds.errors import WorldsError, reworded
from worlds.furniture.registry import own_kinds
from worlds.spec import HouseSpec
from worlds.valid_names import did_you_mean

FORMAT = "lexis-scenario"
_OWN_FURNITURE = "own_furniture"
VERSION = 1
NEEDS_PIXELS = (*OF_IMAGES, ClosedDoors, Pedestrian)
"""Faults that the feature sensor cannot represent, because it has no pixels and sees no moving doors or people."""
_FILE = FileKind("a scenario, such as scenario.json in the folder of a run", 16_000_000, SimError)


@dataclass(frozen=True)
class Scenario(Settings, place="scenario", error=SimError):
    """All settings of a run except the SLAM under test: a house, a tour through it, odometry, faults, cameras and seeds.

    The same scenario gives the same observations. This class holds settings only; `sim.harness.walk` builds house, tour and
    odometry from them.
    """

    preset: str = "home"
    """Family of houses from which the house is sampled; ignored if `house` is given."""
    seed: Annotated[int, Interval(ge=0, lt=2**63)] = 7
    """Seed of the house (if `house` is None), the tour, the odometry and the faults, each with its own random stream."""
    house: HouseSpec | None = None
    """House of the run. None: the house is sampled from preset and seed."""
    length_m: Annotated[float, Interval(gt=0, le=LONGEST_M)] | None = None
    """Requested length of the tour [m]. None: the length that is usual for the preset, or for the kind of tour."""
    tour_kind: TourKind = "rooms"
    """Kind of tour through the house; see `TourConfig.kind`."""
    reverse: bool = False
    """Whether the tour is walked in the opposite direction; see `TourConfig.reverse`."""
    frame_rate_hz: Annotated[float, Interval(ge=0.1, le=FASTEST_HZ)] = 10.0
    """Observations per second [Hz]. With fewer than two observations per keyframe, LEXIS triangulates no landmarks."""
    sway: SwayName = "none"
    """Gait whose sway is added to the motion of the camera; see `sim.tours.sway`."""
    start_manoeuvre: bool = False
    """Whether the body swings on the spot for five seconds before the tour."""
    odometry: str = "multicam"
    """Preset for the drift of the odometry: a key of `sim.odometry.ODOMETRY_PRESETS`."""
    overconfidence: Annotated[float, Ge(1)] = 1.0
    """Factor by which the odometry's covariances are too small; at 1 they match its errors."""
    fidelity: Fidelity = "render"
    """Input of the SLAM. render: rendered images. features: embeddings that the feature sensor predicts from true views."""
    encoder: str = "mini"
    """Name of the vision-language model that LEXIS uses, unless LEXIS is given another one, and that the feature sensor
    imitates. With fidelity "features", `ORACLE` is valid too: an encoder that is told the truth."""
    feature_model: Path | None = None
    """File with the feature model that `lexis-sim fit-features` has fitted to the encoder. None: the included model of
    `mini`."""
    faults: tuple[Fault, ...] = ()
    """Faults in the order in which they act; see `sim.faults`."""
    rig: RigConfig = field(default_factory=RigConfig)
    """Cameras on the body. The SLAM gets the images of all pinhole cameras; recordings contain them, too."""

    def __post_init__(self) -> None:
        """Raise SimError for a value that is not valid, or for values that contradict each other."""
        super().__post_init__()
        if self.odometry not in ODOMETRY_PRESETS:
            guess = did_you_mean(self.odometry, ODOMETRY_PRESETS)
            raise SimError(f"unknown odometry {self.odometry!r}{guess}; valid: {', '.join(ODOMETRY_PRESETS)}")
        if not isinstance(self.faults, tuple) or not all(isinstance(fault, Fault) for fault in self.faults):
            self.refuse("faults", 'a tuple of faults, such as (parse_fault("kidnap:20"),); see sim.faults')
        house: object = self.house
        if house is not None and not isinstance(house, HouseSpec):
            self.refuse("house", "a HouseSpec, such as HouseSpec.load(path), or None")
        rig: object = self.rig
        if not isinstance(rig, RigConfig):
            self.refuse("rig", "a RigConfig, such as RigConfig('stereo')")
        if self.fidelity == "render" and self.encoder == ORACLE:
            raise SimError(f"encoder {ORACLE!r} is told the truth and sees no images; valid: with fidelity 'features'")
        self._check_imitated()
        unseen = [fault.name for fault in self.faults if isinstance(fault, NEEDS_PIXELS)]
        if self.fidelity == "features" and unseen:
            raise SimError(f"fault {unseen[0]!r} is seen in images only; valid: with fidelity 'render'")

    def _check_imitated(self) -> None:
        """Raise SimError if the included feature model, which imitates `mini`, would stand for another encoder."""
        if self.fidelity == "features" and self.feature_model is None and not may_be_imitated(self.encoder):
            guess = did_you_mean(self.encoder, ENCODERS_ON_FEATURES)
            valid = f"{', '.join(ENCODERS_ON_FEATURES)}; others with a feature_model of their own, or with fidelity 'render'"
            raise SimError(f"encoder {self.encoder!r:.60}{guess} is not the one that features imitate; valid: {valid}")

    def data(self) -> dict[str, Any]:
        """Return the scenario as plain data for JSON; `scenario_from_data` is the inverse.

        If the user has declared kinds of furniture, the data name them, because without them another house would be built.
        """
        plain = {each.name: getattr(self, each.name) for each in fields(self)}
        own = {_OWN_FURNITURE: [kind.name for kind in kinds]} if (kinds := own_kinds()) else {}
        return (
            {"format": FORMAT, "version": VERSION}
            | plain
            | {
                "house": None if self.house is None else self.house.data(),
                "feature_model": None if self.feature_model is None else str(self.feature_model),
                "faults": [_fault_data(fault) for fault in self.faults],
                "rig": settings_data(self.rig),
            }
            | own
        )

    @property
    def content_hash(self) -> str:
        """Hash of the settings, 16 hexadecimal digits: equal scenarios have equal hashes, also after saving and loading."""
        return hashlib.sha256(json.dumps(_with_whole_numbers(self.data()), sort_keys=True).encode()).hexdigest()[:16]

    def save(self, path: Path) -> None:
        """Write the scenario as JSON. Raises `LexisError` if the file cannot be written."""
        with replaced_file(path) as beside:
            beside.write_text(json.dumps(self.data(), indent=1) + "\n", encoding="utf-8")

    @staticmethod
    def load(path: Path | str) -> "Scenario":
        """Read a scenario from a JSON file. Raises `SimError` or `worlds.WorldsError` that says what is wrong and where."""
        path = Path(path)
        data = read_json(path, _FILE)
        try:
            return scenario_from_data(data)
        except SimError as error:
            raise SimError(f"{path}: {error}") from None
        except WorldsError as error:
            raise reworded(error, f"{path}: {error}") from None


def scenario_from_data(data: object) -> Scenario:
    """Build a scenario from plain data; absent fields get defaults. Raises `SimError` or `worlds.WorldsError` if invalid."""
    if not isinstance(data, Mapping) or data.get("format") != FORMAT:
        raise SimError(f"is no scenario; valid: a JSON object with format {FORMAT!r}")
    if type(data.get("version")) is not int or data["version"] != VERSION:
        raise SimError(f"scenario has version {data.get('version')!r:.40}; valid: {VERSION}")
    _check_declared(data.get(_OWN_FURNITURE, []))
    values = {name: value for name, value in data.items() if name not in ("format", "version", _OWN_FURNITURE)}
    if values.get("house") is not None:
        values["house"] = HouseSpec.from_json(json.dumps(values["house"]))
    if values.get("feature_model") is not None:
        values["feature_model"] = Path(str(values["feature_model"]))
    if "faults" in values:
        values["faults"] = _faults(values["faults"])
    return settings_of(Scenario, values)


def _check_declared(kinds: object) -> None:
    """Raise `SimError` unless all kinds of furniture are declared that were declared where the scenario was made."""
    if not isinstance(kinds, list) or not all(isinstance(kind, str) for kind in kinds):
        raise SimError(f"scenario.{_OWN_FURNITURE} is {kinds!r:.60}; valid: a list of names")
    if missing := sorted(set(kinds) - {kind.name for kind in own_kinds()}):
        raise SimError(
            f"scenario was made with a kind of furniture that is not declared here, {missing[0]!r:.60}, so that the house "
            "would be another one; valid: a program or test that imports the module with its @furniture"
        )


def _with_whole_numbers(data: Any) -> Any:
    """Replace numbers such as 4.0 by 4 in JSON data: a setting may hold either, and both have to give the same hash."""
    if isinstance(data, dict):
        return {key: _with_whole_numbers(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_with_whole_numbers(value) for value in data]
    return int(data) if isinstance(data, float) and data.is_integer() else data


def _fault_data(fault: Fault) -> dict[str, Any]:
    """Return a fault's name and the fields that differ from their defaults. JSON cannot hold defaults that are infinite."""
    return {"name": fault.name} | {
        each.name: getattr(fault, each.name) for each in fields(fault) if getattr(fault, each.name) != each.default
    }


def _faults(data: object) -> tuple[Fault, ...]:
    if not isinstance(data, list) or not all(isinstance(item, Mapping) for item in data):
        raise SimError("scenario.faults is no list of objects; valid: objects with a name and fields")
    return tuple(map(_fault, data))


def _fault(data: Mapping[str, Any]) -> Fault:
    name = data.get("name")
    kind = FAULTS.get(name) if isinstance(name, str) else None
    if kind is None:
        raise SimError(f"scenario.faults: unknown fault {name!r:.60}; valid: {', '.join(FAULTS)}")
    values = {key: value for key, value in data.items() if key != "name"}
    known = {each.name: each.type for each in fields(kind)}
    for key, value in values.items():
        if key not in known:
            raise SimError(f"scenario.faults: {name} has no field {key!r:.60}; valid: {', '.join(known)}")
        whole = known[key] is int
        if type(value) not in (int, *(() if whole else (float,))):
            raise SimError(f"scenario.faults: {name}.{key} is {value!r:.60}; valid: a {'whole ' if whole else ''}number")
    try:
        return kind(**values)
    except SimError as error:
        raise SimError(f"scenario.faults: {error}") from None
