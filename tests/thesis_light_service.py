"""The light service on raw messages, which is an example, for tests and as an app ``thesis_light_service:…``."""

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

from homebot.apps import App

__all__ = ["THESIS_LIGHT_SERVICE", "ThesisLightService"]

_NAME = "thesis_light_service"
_FILE = Path(__file__).parent.parent / "examples" / "07_thesis_light_service" / f"{_NAME}.py"

THESIS_LIGHT_SERVICE = f"{_NAME}:ThesisLightService"
"""The class as a configuration names it."""


def _load() -> type[App]:
    spec = spec_from_file_location(_NAME, _FILE)
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules[_NAME] = module_from_spec(spec)
    spec.loader.exec_module(module)
    loaded: object = module.ThesisLightService
    assert isinstance(loaded, type)
    assert issubclass(loaded, App)
    return loaded


ThesisLightService = _load()
