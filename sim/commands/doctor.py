"""`lexis-sim doctor`: check whether this machine can run the simulator, and say what to fix."""

import argparse

from lexis.command_line import Commands, add_command


def add_to(commands: Commands) -> None:
    """Add the command `doctor`."""
    add_command(
        commands,
        "doctor",
        _doctor,
        "check GL back ends, cores, encoder and versions, and say what to fix",
        "lexis-sim doctor",
    )


def _doctor(arguments: argparse.Namespace) -> int:
    from sim.doctor import examine

    findings = examine()
    for finding in findings:
        print(f"{'ok ' if finding.fine else 'FIX'} {finding.subject}: {finding.detail}")
    return 0 if all(finding.fine for finding in findings) else 1
