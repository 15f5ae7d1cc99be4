"""Settings and functions without the type checks that the tests add to all code, to see the checks of their own alone."""

import inspect
from dataclasses import MISSING, fields


def unchecked(settings, /, **values):
    """An instance of a class of settings, as a user without type checks makes it."""
    made = object.__new__(settings)
    for field in fields(settings):
        if field.name not in values:
            values[field.name] = field.default_factory() if field.default is MISSING else field.default
        object.__setattr__(made, field.name, values[field.name])
    if hasattr(made, "__post_init__"):
        made.__post_init__()
    return made


def untyped(function):
    """A function or a method without the type checks that the tests add to it, to see the checks of its own."""
    return inspect.unwrap(function)
