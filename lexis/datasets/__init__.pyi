from .dataset import Dataset as Dataset
from .dataset import open_dataset as open_dataset
from .recorded import DatasetConfig as DatasetConfig
from .tum_rgbd import write_dataset as write_dataset
