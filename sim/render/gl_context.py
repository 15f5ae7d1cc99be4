"""`GlContext`: an off-screen OpenGL context with MuJoCo's resources, which are freed without harm to other contexts.

OpenGL numbers the resources (textures, buffers, display lists) of every context from 1, and deletes those with the given
numbers in whatever context is current in the calling thread. A renderer that is dropped without being closed, or that the
garbage collector closes, would thus delete resources of another renderer, which would then draw wrong images or crash. So
resources are only ever freed while their own context is current. A context is current only while it is drawn in, because one
that is current in a thread cannot be freed by any other thread.

Only one thread at a time draws, although every thread has a context of its own: software renderers have crashed when two
threads drew at once.
"""

import threading
import weakref
from collections.abc import Iterator
from contextlib import contextmanager

from sim.render.gl import graphics_errors, mujoco

_DRAWING = threading.RLock()
"""Held by the thread that uses OpenGL. The garbage collector may free a context in a thread that draws in another one."""


class GlContext:
    """The GL context and the resources of a model. Call `close` at the end.

    Any thread may use a context, but only one thread at a time. Raises `GraphicsError` if off-screen OpenGL fails.
    """

    def __init__(self, model: "mujoco.MjModel") -> None:
        self.size = model.vis.global_.offwidth, model.vis.global_.offheight
        """Largest width and height of an image."""
        with _DRAWING, graphics_errors(f"a context of {self.size[0]} x {self.size[1]} px"):
            self._gl = mujoco.GLContext(*self.size)
            with self._gl.as_current():
                self.resources = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
                mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self.resources)
        self._finalizer = weakref.finalize(self, _free, self._gl, self.resources)

    @property
    def is_open(self) -> bool:
        """Whether `close` has not been called yet."""
        return self._finalizer.alive

    @contextmanager
    def as_current(self) -> Iterator[None]:
        """Let the OpenGL calls of this thread go to this context in a `with` block."""
        with _DRAWING, self._gl.as_current():
            yield

    def close(self) -> None:
        """Free the context. Further calls have no effect."""
        self._finalizer()


def _free(gl: "mujoco.GLContext", resources: "mujoco.MjrContext") -> None:
    with _DRAWING:
        with gl.as_current():
            resources.free()
        gl.free()
