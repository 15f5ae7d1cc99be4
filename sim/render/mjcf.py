"""Writes a house as MJCF: an XML file and a folder of textures, for MuJoCo and other software that reads its models."""

from pathlib import Path

from lexis.files.replace import replaced_file, replaced_folder
from sim.render.collision_geoms import add_collisions
from sim.render.image_files import encoded
from sim.render.scene import house_mjspec
from worlds.house import House
from worlds.visuals.house_visuals import visuals

_MARKER = "textures-of-a-house.txt"


def write_mjcf(house: House, path: Path) -> None:
    """Write `path` (.xml) and, beside it, the folder "<stem>_textures". Raises `LexisError` if either cannot be written."""
    folder = path.with_name(f"{path.stem}_textures")
    seen = visuals(house)
    files = {name: f"{folder.name}/{i:03d}.png" for i, name in enumerate(seen.images)}
    pictures = {files[name]: encoded(image, ".png") for name, image in seen.images.items()}
    spec = house_mjspec(house, seen, files)
    add_collisions(spec, house)
    spec.assets = pictures  # in memory, so that the model is compiled before any file is written
    spec.compile()
    text = spec.to_xml()
    with replaced_folder(folder, _MARKER) as beside:
        (beside / _MARKER).write_text(
            "".join(f"{Path(files[name]).name}\t{name}\n" for name in seen.images), encoding="utf-8"
        )
        for name, content in pictures.items():
            (beside / Path(name).name).write_bytes(content)
        # The XML is written before the folder is moved into place, so that a full disk leaves neither of them behind.
        with replaced_file(path) as file:
            file.write_text(text, encoding="utf-8")
