"""`standard_output`: standard output as a console of rich, for tables."""

from typing import NoReturn

from rich.console import Console


class _Console(Console):
    """A console that passes on the error of a broken pipe. By default, rich then ends the process."""

    def on_broken_pipe(self) -> NoReturn:
        """Raise the error of the broken pipe again; rich calls this method while it handles the error."""
        self.quiet = True
        raise


def standard_output(columns: int | None = None) -> Console:
    """Return standard output as a console of the given width; by default, as wide as the terminal."""
    return _Console(width=columns)
