"""Reading of a bag: a folder of rosbag2, or one of its MCAP files."""

import re
from pathlib import Path

from homebot.errors import UsageError
from homebot.features.bags.mcap_file import McapFile


def bag_files(path: Path) -> tuple[McapFile, ...]:
    """Return the files of the bag *path*, in order; ``metadata.yaml`` may be missing, as after a kill.

    Raises:
        UsageError: There are none.
    """
    if not path.exists():
        raise UsageError(f"there is no bag {path}")
    paths = [path] if not path.is_dir() else sorted(path.glob("*.mcap"), key=_number)
    if not paths:
        others = ", ".join(sorted(file.name for file in (*path.glob("*.db3*"), *path.glob("*.mcap.*"))))
        hint = f", but {others}: convert it with `ros2 bag convert`" if others else ""
        raise UsageError(f"{path} has no MCAP file{hint}")
    return tuple(map(McapFile, paths))


def _number(path: Path) -> tuple[int, str]:
    match = re.search(r"_(\d+)\.mcap$", path.name)
    return int(match[1]) if match else 0, path.name
