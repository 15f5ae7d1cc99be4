from .house_visuals import Visual as Visual
from .house_visuals import Visuals as Visuals
from .house_visuals import visuals as visuals
from .mesh_files import to_glb as to_glb
from .mesh_files import to_trimesh as to_trimesh
from .meshes import Solid as Solid
from .meshes import SolidsMesh as SolidsMesh
from .meshes import solids_mesh as solids_mesh
