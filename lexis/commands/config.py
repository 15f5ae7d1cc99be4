"""`lexis config`: prints all settings with their defaults."""

import argparse
import json

from lexis.command_line import Commands, add_command
from lexis.config import Config
from lexis.settings import settings_data


def add_to(commands: Commands) -> None:
    """Add the command `config`."""
    add_command(commands, "config", _config, "all settings with their defaults, as JSON", "lexis config > settings.json")


def _config(arguments: argparse.Namespace) -> int:
    print(json.dumps(settings_data(Config()), indent=1))
    return 0
