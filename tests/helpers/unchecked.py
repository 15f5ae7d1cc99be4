"""Settings made without the type checks that the tests add to every constructor, to see the checks of the settings alone."""

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
