"""Names of the presets, and the valid ranges of their arguments. This module imports no other module."""

MAX_ROOMS_ASKED = 40
MIN_ROOMS_ASKED = 2
MAX_STOREYS_ASKED = 4
PRESETS = ("home", "ori", "uh2-apt", "uh2-office", "apartment", "office", "clinic", "school", "random")
