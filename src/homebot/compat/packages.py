"""``ament_index_python``: the shared folders of packages, as programs look them up."""

import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path

_NAME = re.compile(r"<name>\s*([\w-]+)\s*</name>")


class PackageNotFoundError(KeyError):
    """There is no package of that name."""


def get_package_share_directory(package_name: str) -> str:
    """Return the shared folder of a package: installed below ``AMENT_PREFIX_PATH``, or the source beside a program.

    Raises:
        PackageNotFoundError: Neither is there.
    """
    for prefix in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        if (share := Path(prefix, "share", package_name)).is_dir():
            return str(share)
    for manifest in _manifests():
        if (name := _NAME.search(manifest.read_text(encoding="utf-8", errors="replace"))) and name[1] == package_name:
            return str(manifest.parent)
    places = "AMENT_PREFIX_PATH, and no package.xml beside or above the program names it"
    raise PackageNotFoundError(f"{package_name} is not below {places}")


def get_package_share_path(package_name: str) -> Path:
    """Return :func:`get_package_share_directory` as a path."""
    return Path(get_package_share_directory(package_name))


def get_package_prefix(package_name: str) -> str:
    """Return the folder below which a package is installed; its source if it is not."""
    share = get_package_share_path(package_name)
    return str(share.parents[1] if share.parent.name == "share" else share)


def _manifests() -> Iterator[Path]:
    """Yield the manifests above the folders of the programs, and those beside these."""
    for folder in map(Path, sys.path):
        for above in (folder, *folder.parents[:3]):
            yield from filter(Path.is_file, (above / "package.xml", *above.parent.glob("*/package.xml")))
