"""The page of homebot on a package index, made from README.md when a package is built."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

_FILE = r"\[([^\]]+)\]\((?![a-z]+:|#)([^)\s]+)\)"


class PackagePage(MetadataHookInterface):
    """README.md with absolute links, and the addresses of the project.

    The table ``[tool.hatch.metadata.hooks.custom]`` has its ``repository``; without one the text has no pictures and no
    links to files, as they would lead nowhere.
    """

    def update(self, metadata: dict[str, Any]) -> None:
        """Set the readme and the URLs."""
        repository = self.config["repository"]
        picture, link = ("", r"\1")
        if repository:
            picture, link = (rf"![\1]({repository}/raw/HEAD/\2)", rf"[\1]({repository}/blob/HEAD/\2)")
        readme = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        text = re.sub(_FILE, link, re.sub(f"!{_FILE}", picture, readme))
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
        pages = {"Source": "", "Documentation": "/tree/HEAD/docs", "Changelog": "/blob/HEAD/CHANGELOG.md"}
        metadata["urls"] = {name: f"{repository}{path}" for name, path in pages.items()} if repository else {}
