"""Progress bars on standard error; there are none if it is no terminal."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from rich.console import Console
from rich.progress import Progress, TimeElapsedColumn

_Item = TypeVar("_Item")


@contextmanager
def progress_bar(work: str) -> Iterator[Callable[[float], None]]:
    """Show a progress bar; yield the function to call with the share of the work that is done, in [0, 1]."""
    with _bar() as bar:
        task = bar.add_task(work, total=1.0)
        yield lambda share: bar.update(task, completed=share)


def tracked(items: Iterable[_Item], total: int, what: str) -> Iterator[_Item]:
    """Yield the items, with a progress bar until the last of them."""
    with _bar() as bar:
        yield from bar.track(items, total=total, description=what)


def _bar() -> Progress:
    console = Console(stderr=True)
    columns = *Progress.get_default_columns(), TimeElapsedColumn()
    return Progress(*columns, console=console, transient=True, disable=not console.is_terminal)
