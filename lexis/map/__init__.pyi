from .encoder_check import check_encoder as check_encoder
from .export import export_map as export_map
from .folder import load_map as load_map
from .folder import save_map as save_map
from .info import info_text as info_text
from .info import map_info as map_info
from .picture import map_svg as map_svg
from .relabelling import relabel as relabel
