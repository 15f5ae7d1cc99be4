"""LEXIS on a folder of images with odometry: the map is written beside the images.

The folder holds `rgb.txt`, `odometry.tum` and `camera.json` (see lexis/datasets/tum_rgbd.py), an EuRoC dataset or a ROS 2
bag. Run it: `python tests/examples/folder_of_images.py FOLDER`
"""

import sys
from pathlib import Path

from lexis import LexisMap, Slam, load_encoder, open_dataset, save_map

ROOM_NAMES = ("kitchen", "living room", "bedroom", "bathroom", "office", "corridor", "stairs")


def main(folder: Path) -> LexisMap:
    """Build the map of a recording, print its rooms, and save it in the folder `<recording>-map`."""
    recording = open_dataset(folder)
    slam = Slam(recording.camera, load_encoder("mini"), ROOM_NAMES)
    for observation in recording:
        # An observation has an image, the pose by the drifting odometry, and the covariance of the last motion.
        slam.process(observation)
    lexis_map = slam.finish()
    for room in lexis_map.rooms:
        print(f"{room.label} on floor {room.floor}: keyframes {room.keyframes}")
    save_map(lexis_map, folder.with_name(f"{folder.name}-map"))
    return lexis_map


if __name__ == "__main__":
    main(Path(sys.argv[1]))
