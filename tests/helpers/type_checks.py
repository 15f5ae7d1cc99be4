"""Checks of types at run time, by an import hook that has to be installed before anything else loads the project.

beartype's hook checks types and numbers of axes, and costs a tenth of the time where arrays are large (92 s instead of 84 s
for tests/lexis/sight, tests/lexis/graph and tests/sim/tours), and up to a third where calls are many (68 s instead of 52 s
for the apartments and offices of tests/fresh_houses/test_features.py). jaxtyping's hook also checks that axes of one name
have one length, and takes three times as long. What pytest has loaded by then, such as our own plugin, has no arrays.
"""

import sys
import typing
from functools import cache
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path

import numpy as np
from beartype import BeartypeConf, beartype
from beartype.claw import beartype_packages
from jaxtyping import Float64, install_import_hook

_CHECKED = ("lexis", "sim", "worlds")
_TOP = Path(__file__).parents[2]
_SETTINGS = {"is_pep484_tower": True}  # whole numbers are valid as floats, as for mypy

checked = beartype(conf=BeartypeConf(**_SETTINGS))
"""The decorator that jaxtyping's hook applies."""


def check_types(axes: bool) -> None:
    """Check the types of all arguments and results in the project from now on, and with `axes` also the lengths of axes."""
    if axes:
        install_import_hook(_CHECKED, f"{__name__}.checked")
        return
    configuration = BeartypeConf(
        **_SETTINGS,
        claw_is_pep526=False,  # local variables are annotated for mypy, and need no check
        claw_skip_package_names=_with_late_imports(),
    )
    sys.meta_path.insert(0, _UnchangedByPytest)
    beartype_packages(_CHECKED, conf=configuration)
    _remember_answers()


class _UnchangedByPytest(PathFinder):
    """Finds the modules of the project, which pytest would load itself otherwise, without beartype's hook.

    pytest rewrites the assertions in all modules of a package that has a plugin, and `sim` has one.
    """

    @classmethod
    def find_spec(cls, fullname, path=None, target=None) -> ModuleSpec | None:
        """Return where a module of the project is; None for any other module."""
        return super().find_spec(fullname, path, target) if fullname.split(".")[0] in _CHECKED else None


def _with_late_imports() -> tuple[str, ...]:
    """The modules that import some types for mypy only, which beartype cannot look up by their names."""
    paths = (path for name in _CHECKED for path in (_TOP / name).rglob("*.py"))
    late = (path.relative_to(_TOP) for path in paths if "if TYPE_CHECKING:" in path.read_text())
    return tuple(".".join(path.with_suffix("").parts) for path in late)


def _remember_answers() -> None:
    """Let jaxtyping remember whether a value has a type, because the checks would cost a quarter of the time otherwise.

    Without the lengths of other axes, the answer depends only on the type, on the class of the value, and on the dtype and
    the shape of an array. Python 3.11 also collects the members of a protocol anew in each check, which is remembered too.
    """
    kind = type(Float64[np.ndarray, "n"])
    has_type, answers = kind.__instancecheck__, {}

    def remembered(self, value) -> bool:
        if type(value) is np.ndarray:
            question = (self, value.dtype, value.shape)
        elif hasattr(value, "shape"):  # such as a tensor
            return has_type(self, value)
        else:
            question = (self, type(value))
        if question not in answers:
            answers[question] = has_type(self, value)
        return answers[question]

    kind.__instancecheck__ = remembered
    typing._get_protocol_attrs = cache(typing._get_protocol_attrs)
