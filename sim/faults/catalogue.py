"""All faults by name, and their notation on the command line."""

from collections.abc import Mapping
from dataclasses import Field
from types import MappingProxyType

from sim.errors import SimError
from sim.faults.delivery import Dropped, Duplicated, Frozen, Late, OutOfOrder
from sim.faults.fault import Fault, settings
from sim.faults.images import Blur, Exposure, LightsOff, Noise, Smear
from sim.faults.poses import Kidnap, OdometryFreeze, OdometryJump, OdometryNaN
from sim.faults.stamps import StampJitter, StampJump, StampOffset
from sim.faults.world import ClosedDoors, MovedFurniture, Pedestrian
from worlds.valid_names import did_you_mean

FAULTS: Mapping[str, type[Fault]] = MappingProxyType(
    {
        kind.name: kind
        for kind in (
            *(Dropped, Frozen, Duplicated, Late, OutOfOrder),
            *(StampOffset, StampJitter, StampJump),
            *(Blur, Exposure, Noise, Smear, LightsOff),
            *(OdometryJump, OdometryFreeze, OdometryNaN, Kidnap),
            *(MovedFurniture, ClosedDoors, Pedestrian),
        )
    }
)


def parse_fault(text: str) -> Fault:
    """Parse a fault, given as `name`, `name:value`, `name:field=value,...` or `name:value,field=value,...`.

    A value without a field is the value of the fault's first field. Values have the units of the fields. Raises `SimError`
    for anything but a text, for an unknown name or field, for a field that is given twice, and for a value that is no number
    or out of range.
    """
    if not isinstance(text, str):
        raise SimError(f"fault is {text!r:.60}; valid: a text, such as 'kidnap:20'")
    name, _, rest = text.partition(":")
    if (kind := FAULTS.get(name)) is None:
        raise SimError(f"unknown fault {name!r}{did_you_mean(name, FAULTS)}; valid: {', '.join(FAULTS)}")
    known = {each.name: each for each in settings(kind)}
    first, values = next(iter(known)), {}
    for place, item in enumerate(rest.split(",") if rest else ()):
        key, equals, value = item.rpartition("=")
        key = key if equals or place else first
        if key not in known:
            if not equals:
                rest_of = ", ".join(f"{field}={item}" for field in list(known)[1:])
                raise SimError(f"fault {text!r}: {item!r} has no field; valid: {rest_of or f'one value for {name}'}")
            guess = did_you_mean(key, known)
            raise SimError(f"fault {text!r}: {key or item!r} is no field of {name}{guess}; valid: {', '.join(known)}")
        if key in values:
            raise SimError(f"fault {text!r}: {key} is given twice; valid: once")
        values[key] = _number(text, known[key], value)
    return kind(**values)


def written(fault: Fault) -> str:
    """Return a fault as text, from which `parse_fault` makes the same fault. Fields that are None are left out."""
    values = {of.name: getattr(fault, of.name) for of in settings(type(fault))}
    return f"{fault.name}:{','.join(f'{name}={_digits(value)}' for name, value in values.items() if value is not None)}"


def _digits(value: int | float) -> str:
    """Return a number as short as possible, but with all its digits."""
    short = f"{value:g}"
    return short if isinstance(value, float) and float(short) == value else str(value)


def _number(text: str, of: "Field[float]", value: str) -> int | float:
    try:
        return int(value) if of.type is int else float(value)
    except ValueError:
        kind = "a whole number" if of.type is int else "a number"
        raise SimError(f"fault {text!r}: {of.name} is {value!r}; valid: {kind}") from None


def usage() -> str:
    """Return a help text that lists all faults, one per line, with fields and defaults in the notation of `parse_fault`."""
    return "\n".join(f"  {name}:{','.join(map(_usage, settings(kind)))}" for name, kind in FAULTS.items())


def _usage(of: "Field[float]") -> str:
    shown = "half the tour" if of.default is None else f"{of.default:g}"
    return f"{of.name}={shown}"
