"""Options that put methods of the user's own beside LEXIS in benchmarks."""

import math
from collections.abc import Collection, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from lexis.errors import one_line
from sim.commands.arguments import argument
from sim.commands.named_object import named_object
from sim.errors import USER_ERRORS, SimError
from sim.wording import error_text

if TYPE_CHECKING:
    from sim.bench.peers.own_methods import OwnSegmentation
    from sim.bench.peers.place_methods import Contestant

_FORM = "MODULE:NAME"
SEGMENTATION = argument(
    "--segmentation",
    action="append",
    default=[],
    metavar=_FORM,
    help="a segmentation of the true map of your own, in a module of the current folder or on Python's path: a class "
    "without arguments, or an instance, with the method segments(free, resolution_m); may be repeated",
)
PLACE_METHOD = argument(
    "--place-method",
    action="append",
    default=[],
    metavar=f"{_FORM}[=SCORE]",
    help="a method of place recognition of your own, in a module of the current folder or on Python's path: a class without "
    "arguments, or an instance, with the method scores(seen). It answers a query if its best score is at least SCORE; "
    "find SCORE by --tune on other houses (default: it answers every query that has a candidate); may be repeated",
)


def own_segmentations(texts: Sequence[str]) -> "dict[str, OwnSegmentation]":
    """Return the segmentations that the option `--segmentation` names, by the names of their rows.

    Raises `SimError` for a text that names no segmentation, and for a name that another row of the table has.
    """
    from sim.bench.peers.difficulty_sweep import METHODS
    from sim.bench.peers.own_methods import OwnSegmentation

    found: dict[str, OwnSegmentation] = {}
    for text in texts:
        place = f"--segmentation {text!r:.80}"
        method = _own_method(place, text, "my_rooms:MyRooms", "segments", ("free", "resolution_m"))
        name = _free_name(place, text, {*METHODS, *found})
        found[name] = OwnSegmentation(name, method)
    return found


def own_places(texts: Sequence[str]) -> "dict[str, Contestant]":
    """Return the methods that the option `--place-method` names, with their least scores, by the names of their rows.

    Raises `SimError` for a text that names no method of place recognition, for a score that is not a finite number, and for
    a name that another row of the table has.
    """
    from sim.bench.peers.own_methods import OwnPlaces
    from sim.bench.peers.place_methods import METHODS, Contestant

    found: dict[str, Contestant] = {}
    for text in texts:
        place = f"--place-method {text!r:.80}"
        named, _, score = text.partition("=")
        least = _least(place, score) if "=" in text else -math.inf
        method = _own_method(place, named, "my_places:MyPlaces", "scores", ("seen",))
        name = _free_name(place, named, {*METHODS, *found})
        found[name] = Contestant(partial(OwnPlaces, name, method), least)
    return found


def _own_method(place: str, text: str, example: str, method: str, parameters: Sequence[str]) -> Any:
    """Return the object that a user names MODULE:NAME, or an instance of the class that is named.

    Raises `SimError`, whose message begins with `place`, unless it has a method of this name with these parameters.
    """
    from sim.harness.slam_under_test import check_method, check_slam_factory

    valid = f"a class without arguments, or an instance, with the method {method}({', '.join(parameters)})"
    found = named_object(text, place, _FORM, example)
    if found is None:
        raise SimError(f"{place}: the module has no {text.partition(':')[2]}; valid: the name of a class or instance in it")
    if isinstance(found, type):
        check_slam_factory(place, found, valid)
        try:
            found = found()
        except USER_ERRORS as error:
            raise SimError(f"{place}: the class raises {one_line(error_text(error), 160)}; valid: {valid}") from error
    check_method(place, found, method, parameters, valid)
    return found


def _free_name(place: str, text: str, taken: Collection[str]) -> str:
    """Return the NAME of MODULE:NAME. Raises `SimError` if another row of the table has it."""
    name = text.partition(":")[2]
    if name in taken:
        raise SimError(f"{place}: another row of the table is named {name!r}; valid: another name for it in its module")
    return name


def _least(place: str, text: str) -> float:
    """Convert a least score. Raises `SimError` unless it is a finite number."""
    try:
        least = float(text)
    except ValueError:
        least = math.nan
    if not math.isfinite(least):
        raise SimError(f"{place}: the score {text!r:.40} is not a finite number; valid: such as my_places:MyPlaces=0.8")
    return least
