"""The patterns that `worlds.materials` colours: functions (surface, generator) -> shade."""
