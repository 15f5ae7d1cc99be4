"""The console script `lexis`, which `python -m lexis` runs too: it loads the commands and runs one.

Loading the commands takes some tenths of a second. Ctrl-C during this time ends the program with one line, as it does later.
"""

import faulthandler
import sys
from importlib import import_module

INTERRUPTED = 130
"""Exit status after an interruption, as shells define it: 128 plus the number of the signal."""


def run_program(module: str) -> int:
    """Import a module, call its function `main`, and return the exit status. Ctrl-C prints one line and gives status 130."""
    locate_crashes()
    try:
        return int(import_module(module).main())
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED


def locate_crashes() -> None:
    """If compiled code crashes in this process, such as that of a SLAM under test, print the Python code that called it."""
    if sys.__stderr__ is not None:  # it is None for a process that was started without one
        faulthandler.enable(sys.__stderr__)


def main() -> int:
    """Run the command that the arguments of the process name, and return its exit status."""
    return run_program("lexis.cli")


if __name__ == "__main__":
    sys.exit(main())
