"""The texture atlas of the furniture: one image that holds a grid of patches, one patch per material and colour."""

import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int, UInt8

from worlds.parts import Colour
from worlds.seeds import house_rng
from worlds.spec import HouseSpec
from worlds.visuals.materials import texture

Paint = tuple[str, Colour, int | None]
"""Material, colour and seed of the paint of a part. The seed is None for most materials, so that pieces of furniture share
paints. For materials in `SHOWN_WHOLE`, it is the piece's own seed, so that no two pieces show the same motif."""

SHOWN_WHOLE = frozenset({"picture", "screen", "scribble"})
"""Materials with a motif, such as pictures. Every piece with such a material has a patch of its own in the atlas, and each
face shows the whole patch. Faces of all other materials show cut-outs of shared patches, true to scale."""

_PATCH_PX = 128
_COLUMNS = 16
_MAX_PATCHES = _COLUMNS * 120
_MARGIN = 1.0 / _PATCH_PX


def paint_of(material: str, colour: Colour, piece_seed: int) -> Paint:
    """Return the paint of a part, the key of its patch in the atlas. `piece_seed` is the seed of the part's piece."""
    return material, colour, piece_seed if material in SHOWN_WHOLE else None


@dataclass(frozen=True, eq=False)
class Atlas:
    """An image made of patches, each of which shows one square metre of a paint.

    The content of a patch depends only on its paint, and on the seeds and the `appearance.texture` of the house.
    """

    image: UInt8[np.ndarray, "h w 3"]
    patch_of: Mapping[Paint, int]

    @staticmethod
    def of(paints: Iterable[Paint], spec: HouseSpec) -> "Atlas":
        """Return the atlas of all `paints`. Once the atlas is full, further paints share the patches of earlier ones."""
        distinct = list(dict.fromkeys(paints))
        rows = -(-min(max(len(distinct), 1), _MAX_PATCHES) // _COLUMNS)
        image = np.zeros((rows * _PATCH_PX, _COLUMNS * _PATCH_PX, 3), np.uint8)
        for place, paint in enumerate(distinct[:_MAX_PATCHES]):
            row, column = (_PATCH_PX * i for i in divmod(place, _COLUMNS))
            image[row : row + _PATCH_PX, column : column + _PATCH_PX] = _patch(paint, spec)
        return Atlas(image, {paint: i % _MAX_PATCHES for i, paint in enumerate(distinct)})

    def place(
        self,
        uv_m: Float64[np.ndarray, "q 4 2"],
        patches: Int[np.ndarray, "q"],
        whole: Bool[np.ndarray, "q"],
        cut: Float64[np.ndarray, "q 2"],
    ) -> Float64[np.ndarray, "q 4 2"]:
        """Texture coordinates of quads, as fractions of the atlas image's width and height; v points upwards.

        `uv_m` are the corners of each quad in its own plane [m], with a smallest u and v of 0. `patches` has the index of
        each quad's patch. A quad that is `whole` shows its whole patch. Any other quad shows a cut-out of the patch, as
        large as the quad; where the quad is larger than the patch, the quad is scaled down to it. `cut`, in [0, 1], is the
        relative position (u, v) of the cut-out within the patch.
        """
        length = 1.0 - 2 * _MARGIN
        extent = np.maximum(uv_m.max(axis=1, keepdims=True), 1e-9)
        scale = np.where(whole[:, None, None], length / extent, np.minimum(1.0, length / extent))
        offset = _MARGIN + cut[:, None] * (length - extent * scale)
        rows = len(self.image) // _PATCH_PX
        row, column = np.divmod(patches, _COLUMNS)
        corner = np.stack([column, rows - 1 - row], axis=-1)[:, None]
        return np.asarray((corner + offset + uv_m * scale) / [_COLUMNS, rows])


def _patch(paint: Paint, spec: HouseSpec) -> UInt8[np.ndarray, "h w 3"]:
    material, colour, own = paint
    levels = [round(255 * channel) for channel in colour]
    rng = house_rng(spec, zlib.crc32(material.encode()), *levels, *([] if own is None else [own]))
    pattern = "bare" if spec.appearance.texture == "poor" else material
    return texture(pattern, colour, rng, (_PATCH_PX, _PATCH_PX), (1.0, 1.0))
