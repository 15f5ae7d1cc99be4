"""Rendering: a house as a MuJoCo model, and off-screen images of the house from various cameras.

`scene` compiles a house into a model of few large meshes (`merged_meshes`). `raster` draws images in a `gl_context` of the
back end that `gl` chooses, and leaves out rooms that, according to `visibility`, cannot be seen through any opening.
`camera`, `rig`, `fisheye` and `lens` simulate kinds of cameras. `collision_geoms` adds obstacles for robots, `actor` and
`decorative_geoms` draw moving things, `mjcf` writes the model to files, and `image_files` encodes images. `gl_probe` tests
GL back ends, and `llvm_order` avoids a crash between libraries.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
