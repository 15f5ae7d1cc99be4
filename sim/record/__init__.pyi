from .recording import record as record
from .settings import write_settings as write_settings
from .take import RecordedFrame as RecordedFrame
from .take import Take as Take
