"""Exceptions of `sim`. All of them derive from `SimError`."""

from collections.abc import Mapping


class SimError(ValueError):
    """A run, an argument or the machine is unusable. The message names the place, the problem and the valid values."""


class ProgramError(SimError):
    """A program under test has failed: it ended with an error, or it took too long."""

    def __init__(self, message: str, how: str, stdout: bytes = b"", stderr: bytes = b"") -> None:
        """Create the error.

        `how` says in a few words what the program did, such as "ends with exit status 3". `stdout` and `stderr` are what
        the program printed.
        """
        super().__init__(message)
        self.how, self.stdout, self.stderr = how, stdout, stderr


class EstimateError(SimError):
    """The estimate of a SLAM under test is not valid: it contradicts itself, or refers to frames that do not exist."""


class ProgramFilesError(ProgramError, EstimateError):
    """A program under test has written files that are not valid."""

    def __init__(self, message: str, files: Mapping[str, bytes], stdout: bytes, stderr: bytes) -> None:
        """Create the error.

        `files` holds the content of what the program wrote, by the names of the files. `stdout` and `stderr` are what the
        program printed.
        """
        super().__init__(message, "writes files that are not valid", stdout, stderr)
        self.files = files


USER_ERRORS = (Exception, SystemExit)
"""What the code of a user may raise. `SystemExit` belongs to it: if it were passed on, its status would become that of the
command, and a failing SLAM might count as one that passes."""


class GraphicsError(SimError):
    """Off-screen OpenGL is missing or failed."""
