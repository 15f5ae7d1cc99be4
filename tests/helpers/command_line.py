"""Runs `lexis-sim` in the process of the test."""

from sim.cli import main


def status_of(argv):
    """Exit status of `lexis-sim` with these arguments, which need not be strings."""
    try:
        return main([str(argument) for argument in argv])
    except SystemExit as end:
        return end.code
