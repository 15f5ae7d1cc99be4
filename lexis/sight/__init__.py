"""Evidence belongs where it was seen: labels and rooms from the free space that the images show (beyond the paper).

An image shows the room that the camera looks into, which near a doorway is not the room that the camera stands in. The paper
gives the label of an image to its own keyframe; these modules give it to the keyframes that stand in what the image shows.
Read them in this order: `visible_space` (where does each camera look?), `pooled_labels` (which label does a keyframe get?),
`room_clusters` (which keyframes are in one room?). `labels.method` and `segmentation.method` in the settings choose between
these modules and the methods of the paper.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
