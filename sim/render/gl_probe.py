"""Tests one off-screen OpenGL back end: `python gl_probe.py egl` (or `osmesa`) exits with 0 if a context can be created.

It uses the standard library only, because the noxfile runs it before any package is installed. `sim.render.gl` runs it in a
child process, because a broken driver may crash the process.
"""

import ctypes
import ctypes.util
import sys
from collections.abc import Callable, Iterator

_EGL_PLATFORM_DEVICE = 0x313F
_EGL_OPENGL_API = 0x30A2
_EGL_OPENGL_CONFIG = (ctypes.c_int * 5)(0x3033, 0x0001, 0x3040, 0x0008, 0x3038)  # pbuffer surface, desktop GL
_OSMESA_RGBA = 0x1908


def _egl_works() -> bool:
    """Return whether a desktop GL context can be created on any EGL device, in the same way as MuJoCo creates one."""
    egl = ctypes.CDLL(ctypes.util.find_library("EGL") or "libEGL.so.1")
    for name in ("eglGetProcAddress", "eglCreateContext"):
        getattr(egl, name).restype = ctypes.c_void_p
    return any(_egl_context(egl, display) for display in _egl_displays(egl))


def _egl_displays(egl: ctypes.CDLL) -> Iterator[ctypes.c_void_p]:
    pointer, integer = ctypes.c_void_p, ctypes.c_int
    query = ctypes.CFUNCTYPE(integer, integer, pointer, pointer)(egl.eglGetProcAddress(b"eglQueryDevicesEXT"))
    display = ctypes.CFUNCTYPE(pointer, integer, pointer, pointer)(egl.eglGetProcAddress(b"eglGetPlatformDisplayEXT"))
    devices, count = (pointer * 32)(), integer()
    if query(len(devices), ctypes.byref(devices), ctypes.byref(count)):
        yield from (pointer(display(_EGL_PLATFORM_DEVICE, device, None)) for device in devices[: count.value])


def _egl_context(egl: ctypes.CDLL, display: ctypes.c_void_p) -> bool:
    config, count = ctypes.c_void_p(), ctypes.c_int()
    return bool(
        display
        and egl.eglInitialize(display, None, None)
        and egl.eglChooseConfig(display, _EGL_OPENGL_CONFIG, ctypes.byref(config), 1, ctypes.byref(count))
        and count.value
        and egl.eglBindAPI(_EGL_OPENGL_API)
        and egl.eglCreateContext(display, config, None, None)
    )


def _osmesa_works() -> bool:
    osmesa = ctypes.CDLL(ctypes.util.find_library("OSMesa") or "libOSMesa.so.8")
    osmesa.OSMesaCreateContextExt.restype = ctypes.c_void_p
    return bool(osmesa.OSMesaCreateContextExt(_OSMESA_RGBA, 24, 8, 0, None))


PROBES: dict[str, Callable[[], bool]] = {"egl": _egl_works, "osmesa": _osmesa_works}
"""Function that tests each back end, in order of preference. OSMesa comes last, because Mesa 25.1 no longer has it."""


def works(backend: str) -> bool:
    """Return whether this process can create a GL context with `backend`."""
    try:
        return PROBES[backend]()
    except (OSError, AttributeError, ValueError):  # no library, no entry point, a null extension pointer
        return False


if __name__ == "__main__":
    sys.exit(0 if works(sys.argv[1]) else 1)
