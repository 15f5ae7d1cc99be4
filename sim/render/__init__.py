"""Rendering: a house as a MuJoCo model, and what cameras see of it off-screen.

`scene` compiles a house into a model of few large meshes (`merged_meshes`) and draws only what `visibility` lets through
doors. `raster` owns the GL context that `gl` chooses; `camera`, `rig`, `fisheye` and `lens` are kinds of cameras.
`collision_geoms` adds what robots collide with, `actor` and `decorative_geoms` draw what moves, `mjcf` writes the model to
files, `image_files` encodes images, and `gl_probe` and `llvm_order` work around drivers.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
