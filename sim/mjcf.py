"""A house as MJCF: one XML beside a folder of textures, for MuJoCo and everything that reads its models."""

from pathlib import Path

import cv2

from lexis.files import replaced_file, replaced_folder
from sim.collision import add_collisions
from sim.scene import house_mjspec
from worlds.house import House
from worlds.visuals import visuals

_MARKER = "textures-of-a-house.txt"


def write_mjcf(house: House, path: Path) -> None:
    """Write `path` (.xml) and, beside it, the folder "<stem>_textures". Raises `LexisError` where that cannot be."""
    folder = path.with_name(f"{path.stem}_textures")
    seen = visuals(house)
    files = {name: f"{folder.name}/{i:03d}.png" for i, name in enumerate(seen.images)}
    spec = house_mjspec(house, seen, files)
    add_collisions(spec, house)
    with replaced_folder(folder, _MARKER) as beside:
        (beside / _MARKER).write_text("".join(f"{Path(files[name]).name}\t{name}\n" for name in seen.images))
        for name, image in seen.images.items():
            cv2.imwrite(str(beside / Path(files[name]).name), image[..., ::-1])
    spec.modelfiledir = str(path.parent)
    spec.compile()
    with replaced_file(path) as file:
        file.write_text(spec.to_xml())
