from .command import TrainingRun as TrainingRun
from .command import train_encoder as train_encoder
from .houses import HouseDraw as HouseDraw
from .houses import draw_houses as draw_houses
from .question_calibration import CalibrationFigures as CalibrationFigures
from .question_calibration import fit_calibration as fit_calibration
from .temperature import fit_temperature as fit_temperature
