"""LEXIS, an indoor SLAM that understands language: RGB images, drifting odometry and a list of room names become a map.

The package needs neither the simulator nor generated houses; it runs unchanged on the data of a real robot. Read `slam.py`
first: it names the stages in the order in which they run. Then read the files of the stages: `keyframes`, `perception` and
`features`, `keyframe_window` (waits for the frames after a keyframe), `landmarks`, the subpackage `graph`,
`place_recognition`, `verification` and `locator`, `semantics` with `room_labels`, `stairs`, `room_segmentation` and
`floors`, the subpackage `planning`, and `merging` (of two maps). `types.py` defines the data that passes between the stages,
`config.py` the settings of the stages. The subpackages support the stages:

- `sight`: labels and rooms by what the images show (the default; `room_labels` and `room_segmentation` are as in the paper).
- `graph`: the pose graph and its optimisation.
- `planning`: shortest paths between rooms.
- `encoder`: the vision-language model that turns images and room names into vectors.
- `datasets`: recorded runs as input.
- `map`: a finished map as files, pictures, directions and summaries.
- `sessions`: further recordings that continue a map, and maps that are merged.
- `questions`: questions to a map in free words.
- `evaluation`: figures that compare a run with the truth.
- `files`: safe reading of untrusted files, and writing that never leaves a file half written.
- `maths`: rigid motions and other small mathematics.
- `commands`: the console script `lexis`, with `cli` and `command_line`.

Glossary:

- features: the AKAZE key points of one image with their binary descriptors.
- percept: the embedding and the features of one image, and perhaps points on what it shows; LEXIS accepts a percept in place
  of the image.
- label: the room name of a keyframe. An instance is one room of that name: two kitchens are two instances.
- query: the new keyframe, for which earlier keyframes of the same place are sought. The command `lexis query`
  has another meaning: it asks a map a question.
- candidate: an earlier keyframe that place recognition proposes for a query. Verification turns it into a loop edge, or
  rejects it.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
