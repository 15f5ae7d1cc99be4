"""Maps in the file formats of other projects: scene graphs, rooms as boxes, and occupancy grids.

- Scene graphs: `spark_dsg` writes a map as a scene graph of Spark-DSG, and `spark_dsg_reader` reads it back.
  `spark_dsg_format` defines what both share: layers, names of nodes, and the checked form of the file.
- Plans: `room_areas` divides the free cells of a storey (`lexis.sight.storey_grid`) among the rooms. `hydra_rooms` writes
  the rooms as boxes for Hydra's evaluator, and `ros_map` writes the grids for ROS, with the rooms as polygons.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
