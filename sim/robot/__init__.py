"""A robot that drives what LEXIS plans: a body in MuJoCo, a range scan, pure pursuit by its own drifting estimate."""

from sim.robot.dead_reckoning import DeadReckoning
from sim.robot.drive import DROP, Drive, Robot

__all__ = ["DROP", "DeadReckoning", "Drive", "Robot"]
