"""Makes a copy of LEXIS in which the text of one module is changed (`mutated_copy`)."""

import hashlib
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import lexis
from sim.errors import SimError


@dataclass(frozen=True)
class Mutant:
    """A plausible bug of a SLAM, as a change of the text of one module of LEXIS."""

    name: str
    """The mistake of the programmer, in a few words."""
    file: str
    """Path of the module, relative to the folder of the package `lexis`."""
    before: str
    """Text that occurs exactly once in the module."""
    after: str
    """Text that replaces `before`."""

    def applied(self, text: str) -> str:
        """Return the changed text of the module. Raises `SimError` unless `before` occurs exactly once."""
        if (count := text.count(self.before)) != 1:
            raise SimError(f"mutant {self.name!r}: its text occurs {count} times in {self.file}; valid: once")
        return text.replace(self.before, self.after)

    @property
    def fingerprint(self) -> str:
        """Hash of LEXIS and of the change: another one if either of them changes."""
        return _hash(_hash_of_lexis(), self.file, self.before, self.after)


@contextmanager
def mutated_copy(mutant: Mutant | None) -> Iterator[Path]:
    """Yield a folder with a copy of the package `lexis` that contains a mutant; the copy is unchanged if `mutant` is None.

    Python imports this copy if the folder comes first on Python's path. Files other than modules, such as the weights of the
    encoder, are symbolic links to the original files. The folder is deleted at the end of the context.
    """
    source = Path(lexis.__file__).parent
    with TemporaryDirectory(prefix="lexis-mutant-") as folder:
        copy = Path(folder) / "lexis"
        shutil.copytree(source, copy, copy_function=_copied, ignore=shutil.ignore_patterns("__pycache__"))
        if mutant is not None:
            module = copy / mutant.file
            module.write_text(mutant.applied(module.read_text(encoding="utf-8")), encoding="utf-8")
        yield Path(folder)


def _hash_of_lexis() -> str:
    source = Path(lexis.__file__).parent
    modules = sorted(source.rglob("*.py"))
    return _hash(*(text for path in modules for text in (str(path.relative_to(source)), path.read_text(encoding="utf-8"))))


def _hash(*texts: str) -> str:
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()[:16]


def _copied(source: str, target: str) -> None:
    """Copy a module, so that the code is that of the fingerprint even if somebody edits it meanwhile; link other files."""
    if source.endswith(".py"):
        shutil.copy(source, target)
    else:
        Path(target).symlink_to(source)
