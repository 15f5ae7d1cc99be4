"""The order in which the two LLVMs of a process are loaded: that of torch's compiler Triton, then that of Mesa's drivers.

Mesa's software renderer is linked against the system's LLVM and loaded with RTLD_GLOBAL, so that from then on its LLVM
offers its symbols to every library that follows. Triton's library contains an LLVM of another version: loaded after Mesa,
it takes some of the older symbols for its own, and the process ends with SIGSEGV while Triton is imported (Mesa 22.3 with
LLVM 15; Triton 3.8 and 3.9). Triton's library loaded first has only its own symbols to find, and keeps them to itself.
"""

import ctypes
import importlib.util
from contextlib import suppress
from pathlib import Path


def load_triton_library() -> None:
    """Load Triton's shared library where Triton is installed: neither Triton nor torch is imported (about 0.05 s, 2 MB)."""
    spec = importlib.util.find_spec("triton")
    for directory in (spec and spec.submodule_search_locations) or ():
        with suppress(OSError):  # a Triton without that library cannot clash with Mesa
            ctypes.CDLL(str(Path(directory, "_C", "libtriton.so")))
