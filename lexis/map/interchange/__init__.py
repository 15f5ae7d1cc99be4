"""Maps in the file formats of other projects.

`spark_dsg` writes a map as a scene graph of Spark-DSG, and `spark_dsg_reader` reads it back. `spark_dsg_format` defines what
both share: layers, names of nodes, and the checked form of the file.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
