"""Settings and functions without the type checks that the tests add to all code, to see the checks of their own alone."""

import inspect


def unchecked(settings, /, *arguments, **values):
    """An instance of a class of settings, as a user without type checks makes it."""
    made = object.__new__(settings)
    untyped(settings.__init__)(made, *arguments, **values)
    return made


def untyped(function):
    """A function or a method without the type checks that the tests add to it, to see the checks of its own."""
    return inspect.unwrap(function)
