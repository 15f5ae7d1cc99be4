"""Writes a house as a 3D model, as data or as a floor plan, in the format that the ending of the file's name chooses."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from lexis.files.replace import replaced_file
from sim.output_files import check_ending
from worlds.house import House

Writer = Callable[[House, Path], None]


def writer_for(path: Path, writers: Mapping[str, Writer]) -> Writer:
    """Return the writer for the ending of `path`. Raises `SimError` if `writers` has no writer for it."""
    check_ending(path, writers)
    return writers[path.suffix.lower()]


def _write_glb(house: House, path: Path) -> None:
    from worlds.visuals.mesh_files import to_glb

    _write(path, to_glb(house))


def _write_mjcf(house: House, path: Path) -> None:
    from sim.render.mjcf import write_mjcf

    write_mjcf(house, path)


def _write_truth(house: House, path: Path) -> None:
    from worlds.truth_json import truth_json

    _write(path, (json.dumps(truth_json(house), indent=1) + "\n").encode())


def _write_geojson(house: House, path: Path) -> None:
    from worlds.plan_import.importer import to_geojson

    _write(path, to_geojson(house.spec).encode())


def _write_room_boxes(house: House, path: Path) -> None:
    from lexis.map.interchange.hydra_rooms import write_room_boxes
    from sim.true_rooms import true_room_boxes

    write_room_boxes(true_room_boxes(house), path)


def _write_png(house: House, path: Path) -> None:
    from sim.report.house_plan import plan_png

    _write(path, plan_png(house))


def _write_svg(house: House, path: Path) -> None:
    from sim.report.house_plan import plan_svg

    _write(path, plan_svg(house).encode())


def _write(path: Path, content: bytes) -> None:
    with replaced_file(path) as file:
        file.write_bytes(content)


MODELS: Mapping[str, Writer] = MappingProxyType(
    {
        ".glb": _write_glb,
        ".xml": _write_mjcf,
        ".json": _write_truth,
        ".geojson": _write_geojson,
        ".yaml": _write_room_boxes,
    }
)
"""Writers by ending. glb: glTF. xml: MJCF, with a folder of textures beside the file. json: the ground truth. geojson: rooms
and openings, in the format that the floor plan import reads. yaml: the true rooms as boxes, for Hydra's evaluator."""
PLANS: Mapping[str, Writer] = MappingProxyType({".png": _write_png, ".svg": _write_svg})
"""Writers of pictures, by ending. A picture shows the floor plans of all storeys side by side."""
