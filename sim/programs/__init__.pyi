from .command import CommandSlam as CommandSlam
from .command import run_command as run_command
