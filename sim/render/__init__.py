"""Rendering: a house as a MuJoCo model, and off-screen images of the house from various cameras.

`scene` compiles a house into a model of few large meshes (`merged_meshes`). `raster` draws only the rooms that `visibility`
finds in view through openings, in a GL context of the back end that `gl` chooses. `camera`, `rig`, `fisheye` and `lens` are
kinds of cameras. `collision_geoms` adds obstacles for robots, `actor` and `decorative_geoms` draw moving things, `mjcf`
writes the model to files, `image_files` encodes images, and `gl_probe` and `llvm_order` work around drivers.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
