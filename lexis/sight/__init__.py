"""Labels and rooms by sight: from the free space that the images show (beyond the paper).

An image shows the room that the camera looks into. Near a doorway, this is not the room in which the camera stands. The
paper gives the label of an image to its own keyframe; these modules give it to the keyframes that stand in the space that
the image shows. Read the modules in this order: `visible_space` (where does each camera look?), `pooled_labels` (which label
does a keyframe get?), `room_clusters` (which keyframes are in one room?), `passages` (where does the path go through a
doorway?), `crossings` (who sees whom through it?), `borders` (which labels change at a doorway?), `divided_rooms` (which
rooms does a wall divide?), `alike_rooms` (which rooms are one, under two names?).

`cameras` joins the cameras of a rig. The settings `labels.method` and `segmentation.method` choose between these modules and
the methods of the paper. `storey_grid` collects the free space of a whole storey, for plans and for maps in other formats.
`cells` are the cells of such grids.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
