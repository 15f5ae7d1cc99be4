"""Loads the LLVM of torch's compiler Triton before the LLVM of Mesa's drivers, because the reverse order crashes.

Mesa's software renderer is linked against the system's LLVM and loaded with RTLD_GLOBAL. The symbols of that LLVM are then
visible to every library loaded later. Triton's library contains an LLVM of another version. If Triton's library is loaded
after Mesa, some of its symbols resolve to symbols of the system's LLVM, and the process ends with SIGSEGV while Triton is
imported (Mesa 22.3 with LLVM 15; Triton 3.8 and 3.9). If Triton's library is loaded first, it uses its own symbols only, and
does not make them visible to Mesa.
"""

import ctypes
import importlib.util
from contextlib import suppress
from pathlib import Path


def load_triton_library() -> None:
    """Load Triton's shared library if it is installed, without importing Triton or torch (about 0.05 s, 2 MB)."""
    spec = importlib.util.find_spec("triton")
    for directory in (spec and spec.submodule_search_locations) or ():
        with suppress(OSError):  # a Triton without that library cannot clash with Mesa
            ctypes.CDLL(str(Path(directory, "_C", "libtriton.so")))
