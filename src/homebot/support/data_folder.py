"""The folder of the data of all homes."""

import os
from pathlib import Path

from platformdirs import user_data_path


def data_directory() -> Path:
    """Return ``HOMEBOT_DATA``, or the user's data directory."""
    if given := os.environ.get("HOMEBOT_DATA"):
        return Path(given)
    return user_data_path("homebot", appauthor=False)
