from .open_clip_encoder import OpenClipEncoder as OpenClipEncoder
from .open_clip_encoder import load_encoder as load_encoder
from .options import EncoderOptions as EncoderOptions
