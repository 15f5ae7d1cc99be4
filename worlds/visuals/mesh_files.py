"""Export of houses as meshes: a trimesh scene or a GLB file of textured triangles.

Each room has one node for its walls, one for its floor and one for its ceiling. Each object has one node.
"""

from io import BytesIO

import numpy as np
import trimesh
from jaxtyping import UInt8
from PIL import Image
from trimesh.visual.material import PBRMaterial
from trimesh.visual.texture import TextureVisuals

from worlds.house import House
from worlds.visuals.house_visuals import Visual, visuals
from worlds.visuals.meshes import triangles

_JPEG_QUALITY = 88
_Y_UP = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


class _Material(PBRMaterial):
    """A material that is known by its name. Otherwise, trimesh reads all pixels of its texture for each mesh that has it."""

    def __hash__(self) -> int:
        """Return the hash of the name."""
        return hash(self.name)


def to_trimesh(house: House) -> trimesh.Scene:
    """Return the house as a scene in the world frame W [m], z up. Each node has the name of its `house_visuals.Visual`."""
    seen, scene = visuals(house), trimesh.Scene()
    materials = {name: _material(name, image) for name, image in seen.images.items()}
    for visual in seen.parts:
        scene.add_geometry(_triangles(visual, materials[visual.image]), node_name=visual.name)
    return scene


def to_glb(house: House) -> bytes:
    """Return the house as a binary glTF file. In glTF, y points up: a point (x, y, z) in W is written as (x, z, -y)."""
    scene = to_trimesh(house)
    scene.apply_transform(_Y_UP)  # type: ignore[no-untyped-call]
    return bytes(scene.export(file_type="glb"))  # type: ignore[no-untyped-call]


def _triangles(visual: Visual, material: PBRMaterial) -> trimesh.Trimesh:
    return trimesh.Trimesh(
        visual.corners.reshape(-1, 3),
        triangles(len(visual.corners)),
        vertex_normals=np.repeat(visual.normals, 4, axis=0),
        visual=TextureVisuals(uv=visual.uv.reshape(-1, 2), material=material),  # type: ignore[no-untyped-call]
        process=False,
    )


def _material(name: str, image: UInt8[np.ndarray, "h w 3"]) -> PBRMaterial:
    # PNG compresses noisy textures badly: JPEG makes the file several times smaller.
    encoded = BytesIO()
    Image.fromarray(image).save(encoded, "JPEG", quality=_JPEG_QUALITY)
    picture = Image.open(encoded)
    return _Material(name=name, baseColorTexture=picture, metallicFactor=0.0, roughnessFactor=1.0)  # type: ignore[no-untyped-call]
