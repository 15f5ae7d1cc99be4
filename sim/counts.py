"""`check_count`: refuses an argument that is no whole number of a range."""

from sim.errors import SimError


def check_count(place: str, value: object, least: int, most: int | None = None) -> None:
    """Raise `SimError` unless `value` is a whole number from `least` to `most`; None stands for no upper limit.

    `place` names the argument in the message, as in "suite: seed".
    """
    if not isinstance(value, bool) and isinstance(value, int) and least <= value and (most is None or value <= most):
        return
    raise SimError(f"{place} is {value!r:.60}; valid: a whole number from {least}" + ("" if most is None else f" to {most}"))
