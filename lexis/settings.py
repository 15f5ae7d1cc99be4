"""Settings that check themselves.

Each field declares its valid values, and the error for another value names the field.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, fields, is_dataclass
from functools import cache
from numbers import Integral, Number, Real
from operator import ge, gt, le, lt
from types import NoneType, UnionType
from typing import Annotated, Any, ClassVar, Literal, SupportsFloat, TypeVar, Union, get_args, get_origin, get_type_hints

from annotated_types import Ge, Gt, Interval, Le, Lt, MinLen

_UNITS = {
    "m_s2": "m/s²", "m_s": "m/s", "rad_s": "rad/s", "rad_m": "rad/m",
    "m": "m", "s": "s", "rad": "rad", "deg": "degrees", "px": "px", "hz": "Hz",
}  # fmt: skip
"""Unit for each ending of a field's name. The first ending in this order that fits decides."""
_KINDS = {int: "a whole number", float: "a finite number", bool: "true or false", str: "a text that is not empty"}
_SIGNS = {Gt: ("gt", ">", gt), Ge: ("ge", ">=", ge), Lt: ("lt", "<", lt), Le: ("le", "<=", le)}
"""For each kind of bound, the name of its limit, its sign, and the comparison that has to hold."""
_Settings = TypeVar("_Settings", bound="Settings")


class Settings:
    """Base class of frozen dataclasses whose annotations declare the valid values.

    `Annotated[float, Gt(0)]` and the like bound a number, `Annotated[str, MinLen(1)]` excludes an empty text, and
    `Literal["a", "b"]` lists the choices. Numbers must be finite; texts and booleans do not count as numbers. A subclass
    gives its `place`, which error messages begin with, and the `error` to raise:

        @dataclass(frozen=True)
        class WalkConfig(Settings, place="walk", error=SimError):
            speed_m_s: Annotated[float, Gt(0)] = 0.7

    `WalkConfig(speed_m_s=-1)` then raises `SimError("walk.speed_m_s is -1; valid: > 0 m/s")`.
    """

    place: ClassVar[str]
    error: ClassVar[type[Exception]]

    def __init_subclass__(cls, *, place: str = "", error: type[Exception] = ValueError) -> None:
        """Store the arguments `place`, with which error messages begin, and `error`, the type of the errors.

        A class without `place` inherits both from its base class.
        """
        if place:
            cls.place, cls.error = place, error

    def __post_init__(self) -> None:
        """Raise the class's error if a field has a value that the field's annotation excludes.

        Numbers of numpy become numbers of Python, which JSON can hold.
        """
        for name, annotation in _annotations(type(self)).items():  # type: ignore[arg-type]
            value = getattr(self, name)
            if isinstance(value, Number) and hasattr(value, "item"):  # a number of numpy, which takes long to import
                object.__setattr__(self, name, value.item())
            if valid := _what_is_valid(getattr(self, name), annotation, _unit(name)):
                self.refuse(name, valid)

    def refuse(self, name: str, valid: str) -> None:
        """Raise the class's error for the field `name`; `valid` describes the valid values."""
        raise self.error(f"{self.place}.{name} is {getattr(self, name)!r}; valid: {valid}")


def settings_data(settings: Settings) -> dict[str, Any]:
    """Return all settings as nested plain data, for JSON or YAML; `settings_of` is the inverse."""
    return asdict(settings)  # type: ignore[call-overload, no-any-return]


def changed_settings(settings: Settings) -> list[str]:
    """Return the settings that differ from their defaults, each as a text such as "place_recognition.candidates=0"."""
    return list(_changed(settings_data(settings), settings_data(type(settings)()), ""))


def _changed(data: Mapping[str, Any], usual: Mapping[str, Any], prefix: str) -> Iterator[str]:
    for name, value in data.items():
        if isinstance(value, Mapping) and isinstance(usual[name], Mapping):
            yield from _changed(value, usual[name], f"{prefix}{name}.")
        elif value != usual[name]:
            yield f"{prefix}{name}={value}"


def settings_of(kind: type[_Settings], data: object, place: str = "") -> _Settings:
    """Build settings from nested plain data; fields that `data` leaves out keep their defaults.

    `place` says in error messages where the data came from. Raises the class's error for unknown names, for data that is no
    mapping, and for values that are not valid.
    """
    at = f"{place}: " if place else ""
    if not isinstance(data, Mapping):
        raise kind.error(f"{at}{kind.place} is {data!r:.80}; valid: names of settings with their values")
    annotations = _annotations(kind)  # type: ignore[arg-type]
    if unknown := [str(name) for name in data if name not in annotations]:
        raise kind.error(f"{at}{kind.place} has no setting {unknown[0]!r:.80}; valid: {', '.join(annotations)}")
    try:
        return kind(**{name: _value(annotations[name], value) for name, value in data.items()})
    except kind.error as error:
        raise kind.error(f"{at}{error}") from None


def _value(annotation: Any, value: object) -> object:
    """Convert a value of JSON data to the type of its field.

    A mapping becomes settings if the field holds settings, a list becomes a tuple, and a whole number becomes a float if the
    field holds floats.
    """
    nested = isinstance(annotation, type) and issubclass(annotation, Settings) and is_dataclass(annotation)
    if nested:
        return settings_of(annotation, value)
    if isinstance(value, list):
        (*_, item) = get_args(annotation) or (Any,)
        return tuple(_value(item, each) for each in value)
    wants_float = float in (annotation, getattr(annotation, "__origin__", None), *_bases(annotation))
    if wants_float and isinstance(value, int) and not isinstance(value, bool) and _is_finite(value):
        return float(value)
    return value


def _bases(annotation: Any) -> tuple[Any, ...]:
    return tuple(getattr(option, "__origin__", option) for option in get_args(annotation))


@cache
def _annotations(kind: type[Settings]) -> dict[str, Any]:
    hints = get_type_hints(kind, include_extras=True)
    return {field.name: hints[field.name] for field in fields(kind)}  # type: ignore[arg-type]


def _unit(name: str) -> str:
    return next((f" {unit}" for end, unit in _UNITS.items() if name.endswith(f"_{end}")), "")


def _what_is_valid(value: object, annotation: Any, unit: str) -> str | None:
    """Describe the valid values if `value` is not valid; return None if it is valid or the annotation sets no limits."""
    origin = get_origin(annotation)
    if origin in (Union, UnionType):
        declared = next(option for option in get_args(annotation) if option is not NoneType)
        said = None if value is None else _what_is_valid(value, declared, unit)
        return said and f"{said}, or null (None in Python)"
    if origin is Literal:
        return None if value in get_args(annotation) else ", ".join(map(str, get_args(annotation)))
    base, bounds = (annotation.__origin__, _bounds(annotation.__metadata__)) if origin is Annotated else (annotation, [])
    if base not in _KINDS or (_is_a(value, base) and all(_holds(value, bound) for bound in bounds)):
        return None
    numeric = [f"{_SIGNS[type(bound)][1]} {_limit(bound):g}" for bound in bounds if type(bound) in _SIGNS]
    if not numeric:
        return _KINDS[base]
    kind = "" if _is_a(value, base) or (base is int and type(value) is int) else f"{_KINDS[base]} "
    return kind + " and ".join(numeric) + unit


def _is_a(value: object, base: type) -> bool:
    if base in (bool, str) or isinstance(value, bool):
        return isinstance(value, base) and base is not int
    return isinstance(value, Integral if base is int else Real) and _is_finite(value)


def _is_finite(value: SupportsFloat) -> bool:
    """Whether a number is finite as a float. Whole numbers of more than 308 digits are not."""
    try:
        return math.isfinite(value)
    except OverflowError:
        return False


def _bounds(metadata: tuple[Any, ...]) -> list[Any]:
    return [bound for item in metadata for bound in (item if isinstance(item, Interval) else (item,))]


def _limit(bound: Any) -> Any:
    return getattr(bound, _SIGNS[type(bound)][0])


def _holds(value: Any, bound: Any) -> bool:
    if isinstance(bound, MinLen):
        return len(value) >= bound.min_length
    return bool(_SIGNS[type(bound)][2](value, _limit(bound)))
