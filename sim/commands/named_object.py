"""`named_object`: imports what an option names as MODULE:NAME, such as the class of a SLAM."""

import importlib
import sys
from pathlib import Path

from lexis.errors import one_line
from sim.errors import USER_ERRORS, SimError
from sim.wording import error_text


def named_object(text: str, place: str, form: str, example: str) -> object:
    """Import the module that `text` names before its colon, and return what the module calls by the name after the colon.

    Returns None if the module has nothing of this name. The module is in the current folder or on Python's path. Raises
    `SimError` for a text of another form, and for a module that cannot be imported. The message begins with `place`; it
    shows the `form`, such as "MODULE:CLASS", and an `example`, such as "my_slam:MySlam".
    """
    module_name, colon, name = text.partition(":")
    if not (module_name and colon and name):
        raise SimError(f"{place}: is no {form}; valid: such as {example}")
    if module_name.endswith(".py"):
        module = ".".join(Path(module_name).with_suffix("").parts)
        raise SimError(f"{place}: names a file; leave out .py: {module}:{name}")
    if "" not in sys.path:
        sys.path.insert(0, "")  # the current folder, as in `python -m`
    try:
        return getattr(importlib.import_module(module_name), name, None)
    except USER_ERRORS as error:
        reason = one_line(error_text(error), 160)
        raise SimError(f"{place}: cannot be imported: {reason}; valid: a module here or on the path") from None
