from .ceiling import ceiling_of as ceiling_of
from .questions import RoomQuestion as RoomQuestion
from .questions import questions_of as questions_of
from .retrieval import found_at_1 as found_at_1
from .runs import EncoderRun as EncoderRun
from .runs import encoder_runs as encoder_runs
from .table import write_csv as write_csv
from .texts import EmbeddedTexts as EmbeddedTexts
