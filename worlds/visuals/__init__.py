"""Visible geometry of a house: textured quads for renderers and exporters.

`surfaces` (with `shell_grid`) finds the visible faces of walls, floors and ceilings, `surface_textures` covers them,
`materials` (with `patterns`) paints textures, `meshes` turns furniture into quads, `atlas` packs small images together,
`house_visuals` collects everything, and `mesh_files` writes glTF through trimesh.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
