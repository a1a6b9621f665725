"""Python without the packages of peers, as ``make test`` has it: ``pytest -p tests.without_peers --collect-only``."""

import re
import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.metadata import packages_distributions
from pathlib import Path
from types import ModuleType

_LOADED_BY_HYPOTHESIS = {"trio", "sniffio", "outcome"}
_LOCKED = Path(__file__).parents[1] / "requirements"


def _locked(*files: str) -> set[str]:
    texts = ((_LOCKED / f"{file}.txt").read_text() for file in files)
    return {name for text in texts for name in re.findall(r"^([\w.-]+)==", text, re.MULTILINE)}


class _WithoutPeers(MetaPathFinder):
    def __init__(self) -> None:
        missing = _locked("peers") - _locked("run", "all", "dev") - _LOADED_BY_HYPOTHESIS
        self._missing = {
            module
            for module, packages in packages_distributions().items()
            if missing.issuperset(re.sub(r"[-_.]+", "-", package).lower() for package in packages)
        }

    def find_spec(
        self, fullname: str, _path: Sequence[str] | None, _target: ModuleType | None = None, /
    ) -> ModuleSpec | None:
        """Raises ModuleNotFoundError for a module of a peer."""
        if fullname.partition(".")[0] in self._missing:
            raise ModuleNotFoundError(f"No module named {fullname!r}", name=fullname)
        return None


sys.meta_path.insert(0, _WithoutPeers())
