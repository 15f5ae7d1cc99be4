from .command import Program as Program
from .command import run_command as run_command
