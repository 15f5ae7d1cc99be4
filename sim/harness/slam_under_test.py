"""Interfaces of the SLAM systems that the harness tests."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Protocol, runtime_checkable

from lexis.errors import encodable
from lexis.types import Camera, Observation
from sim.errors import SimError
from sim.harness.estimate import Estimate
from sim.harness.feature_input import FeatureInput
from sim.harness.last_run import last_run
from sim.wording import class_of, qualified_name


@runtime_checkable
class SlamUnderTest(Protocol):
    """Interface of any SLAM. The harness calls `start` once, `process` for every observation, and `finish` once."""

    def start(self, camera: Camera, room_names: Sequence[str]) -> None:
        """Begin a run with this camera. `room_names` are the labels that rooms may have."""

    def process(self, observation: Observation) -> None:
        """Take the next observation: an RGB image and a pose by drifting odometry.

        An implementation may raise `lexis.errors.ObservationError` to refuse an observation, such as one with a stamp in the
        past. In a scenario with faults, the run then goes on without this observation.
        """

    def finish(self) -> Estimate:
        """Return the SLAM's estimate of the whole run."""


_PARAMETERS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"start": ("camera", "room_names"), "process": ("observation",), "finish": ()}
)
"""The methods of a `SlamUnderTest`, with the names of the arguments that the harness gives to them by position."""
_NO_ARGUMENTS = "a class or function without arguments, such as functools.partial(MySlam, argument)"


def check_slam_methods(slam: object) -> None:
    """Raise SimError unless `slam` has the methods of a `SlamUnderTest`.

    The error names the method that is missing, or that cannot be called with the arguments of the harness.
    """
    if isinstance(slam, type):
        raise SimError(f"SLAM under test: {slam.__name__} is a class; valid: an instance, {slam.__name__}(...)")
    for method, parameters in _PARAMETERS.items():
        check_method("SLAM under test", slam, method, parameters, "start(), process() and finish()")


def check_method(place: str, owner: object, method: str, parameters: Sequence[str], valid: str) -> None:
    """Raise SimError unless `owner` has this method, which takes these parameters by position.

    The message begins with `place`. If the method is missing, the message ends with `valid`.
    """
    name = type(owner).__name__
    if not callable(call := getattr(owner, method, None)):
        raise SimError(f"{place}: {name} has no method {method}(); valid: {valid}")
    function = getattr(call, "__func__", call)
    given = parameters if function is call else ("self", *parameters)
    try:
        found = inspect.signature(function)
    except (TypeError, ValueError):  # methods that are written in C need not have a signature
        return
    try:
        found.bind(*given)
    except TypeError as error:
        bare = [each.replace(annotation=inspect.Parameter.empty) for each in found.parameters.values()]
        takes, needed = f"def {method}{inspect.Signature(bare)}", f"def {method}({', '.join(('self', *parameters))})"
        raise SimError(f"{place}: {name} has {takes}: {error}; valid: {needed}") from None


def check_slam_factory(place: str, new_slam: object, valid: str = _NO_ARGUMENTS) -> None:
    """Raise SimError unless `new_slam`, which shall make a SLAM, can be called without arguments. A `Program` cannot.

    `place` names the argument in the message. If `new_slam` takes arguments, the message ends with `valid`.
    """
    if not callable(new_slam):
        raise SimError(f"{place} is {class_of(new_slam)}; valid: the class of a SLAM, or a function that makes a SLAM")
    try:
        inspect.signature(new_slam).bind()
    except TypeError as error:
        takes = f"{class_of(new_slam)}, which cannot be called without arguments: {error}"
        raise SimError(f"{place} is {takes}; valid: {valid}") from None
    except ValueError:  # a callable that is written in C states no signature
        pass


def made_slam(new_slam: Callable[[], SlamUnderTest]) -> SlamUnderTest:
    """Make a SLAM. Raises `SimError` if what is made is no SLAM.

    An exception that is raised while the SLAM is made counts as an exception of the SLAM, see `sim.harness.crash.attempt`.
    """
    with last_run().calling_slam():
        slam = new_slam()
    check_slam_methods(slam)
    return slam


@runtime_checkable
class PlansPaths(Protocol):
    """Interface of a SLAM that also plans paths between rooms. A simulated robot drives these paths."""

    def plan(self, start: str, goal: str) -> Sequence[int]:
        """Return a path from a room labelled `start` to a room labelled `goal`, as rows of the estimate in driving order.

        The label of a room is the most frequent label of its rows, see `Estimate.named_rooms`. A plan fails if its first row
        is in a room that is labelled `start` neither by the SLAM nor in truth. The harness calls this method after `finish`.
        An implementation raises `lexis.errors.PlanError` if there is no path.
        """


@runtime_checkable
class StatesSettings(Protocol):
    """Interface of a SLAM that states its settings, so that results with different settings can be told apart."""

    @property
    def settings(self) -> str:
        """The settings in a few words, such as "no loops"; an empty text for the usual ones."""


_LONGEST_SETTINGS = 80
"""Greatest number of characters of a SLAM's settings in its title."""


def full_name_of(slam: object) -> str:
    """Return module and class of a SLAM, as the option `--slam` names it, or the command of a program."""
    return slam.command if isinstance(slam, CommandSlam) else qualified_name(slam)


def title_of(slam: object) -> str:
    """Return the name of a SLAM's class, with the settings that the SLAM states in parentheses, or a program's command."""
    if isinstance(slam, CommandSlam):
        return slam.command
    name = type(slam).__name__
    stated = slam.settings if isinstance(slam, StatesSettings) else ""
    if not isinstance(stated, str) or not stated:  # the class may use the name for something else
        return name
    short = stated if len(stated) <= _LONGEST_SETTINGS else f"{stated[: _LONGEST_SETTINGS - 1]}…"
    return encodable(f"{name} ({short})")


@runtime_checkable
class SavesFiles(Protocol):
    """Interface of a SLAM that adds files of its own to the folder of a run."""

    def save(self, folder: Path) -> None:
        """Write files into `folder`, which is empty. The harness calls this method after `finish`.

        The harness then moves the files into the folder of the run, whose own files have other names.
        """


@dataclass(frozen=True)
class CommandSlam:
    """A program that has run. It takes the place of a SLAM object in `Run.slam`, and saves what the program printed."""

    command: str
    stdout: bytes
    stderr: bytes

    def save(self, folder: Path) -> None:
        """Write what the program printed to `program.out` and `program.err`."""
        write_printed(self.stdout, self.stderr, folder)


def write_printed(stdout: bytes, stderr: bytes, folder: Path) -> None:
    """Write what a program printed to `program.out` and `program.err`."""
    (folder / "program.out").write_bytes(stdout)
    (folder / "program.err").write_bytes(stderr)


@runtime_checkable
class AcceptsFeatures(Protocol):
    """Interface of a SLAM that can work on percepts (`lexis.types.Percept`: embeddings of views) instead of images."""

    def start_on_features(self, camera: Camera, room_names: Sequence[str], features: FeatureInput) -> None:
        """Begin a run of fidelity "features". The harness calls this method in place of `start`."""
