from .distance_transform import DistanceTransform as DistanceTransform
from .hydra_places import HydraPlaces as HydraPlaces
from .lexis_variants import LEXIS_VARIANTS as LEXIS_VARIANTS
from .lexis_variants import WordlessLexis as WordlessLexis
from .map_rooms import MapRooms as MapRooms
from .morphological import Morphological as Morphological
from .object_votes import ObjectVotes as ObjectVotes
from .voronoi import Voronoi as Voronoi
