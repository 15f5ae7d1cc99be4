"""The patterns that `worlds.visuals.materials` colours: functions (surface, generator) -> shade."""
