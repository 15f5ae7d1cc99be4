from .drawn_plan import DrawnPlan as DrawnPlan
from .geojson import to_geojson as to_geojson
from .importer import ImportedPlan as ImportedPlan
from .importer import import_plan as import_plan
