"""The console script `lexis-sim`, which `python -m sim` runs too: it loads the commands and runs one."""

import sys

from lexis.__main__ import run_program


def main() -> int:
    """Run the command that the arguments of the process name, and return its exit status."""
    return run_program("sim.cli")


if __name__ == "__main__":
    sys.exit(main())
