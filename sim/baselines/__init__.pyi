from .orb_words import OrbWords as OrbWords
from .orb_words import orb_descriptors as orb_descriptors
