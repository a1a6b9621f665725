"""``homebot new``."""

import argparse
import importlib.util
import keyword
import re
import shlex
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Final

from homebot.cli.arguments import set_command
from homebot.cli.commands.service import unit_text
from homebot.errors import UsageError
from homebot.plugins import has_plugin

_EXAMPLES = """\
  homebot new hall_light          hall_light/ with an app HallLight, its test, configuration, house and service
  cd hall_light && pytest && homebot config check && homebot run --house house.toml
  homebot new integration acme    acme/ with a package homebot_acme: messages on MQTT, simulated devices, tests
  cd acme && pip install -e . && pytest && homebot run --house house.toml
"""

_APP: Final = {
    "app.py.template": "$module.py",
    "test.py.template": "test_$module.py",
    "pytest.ini.template": "pytest.ini",
    "homebot.toml.template": "homebot.toml",
    "house.toml.template": "house.toml",
}
_INTEGRATION: Final = {
    "integration/package.py.template": "$module/__init__.py",
    "integration/formats.py.template": "$module/formats.py",
    "integration/simulated.py.template": "$module/simulated.py",
    "integration/test_formats.py.template": "test_formats.py",
    "integration/test_contract.py.template": "test_contract.py",
    "integration/test_house.py.template": "test_house.py",
    "integration/pyproject.toml.template": "pyproject.toml",
    "integration/homebot.toml.template": "homebot.toml",
    "integration/house.toml.template": "house.toml",
}
_GROUPS: Final = ("homebot.mqtt_conventions", "homebot.simulated")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_command(parser, _new, _EXAMPLES)
    parser.add_argument("kind", nargs="?", choices=("integration",), help="a package for devices; without it, an app")
    parser.add_argument("folder", metavar="FOLDER", help="folder to create; what is in it is named after it")


def _new(options: argparse.Namespace) -> int:
    folder = Path(options.folder).resolve()
    if options.kind is None and options.folder == "integration":
        raise UsageError("an integration needs a name: homebot new integration NAME")
    if options.kind is None:
        module = _module_name(folder.name)
        names = {"module": module, "kind": _kind(module)}
        others = {folder / f"{module}.service": unit_text(folder / "homebot.toml", is_user=True)}
        _write(folder, _texts(folder, _APP, names) | others)
        steps = "pytest && homebot config check"
    else:
        name = _integration_name(folder.name)
        names = {"name": name, "module": f"homebot_{name}", "kind": _kind(name)}
        _write(folder, _texts(folder, _INTEGRATION, names))
        steps = "pip install -e . && pytest"
    print(f"try it: cd {shlex.quote(options.folder)} && {steps} && homebot run --house house.toml")
    return 0


def _kind(name: str) -> str:
    return "".join(word.capitalize() for word in name.split("_"))


def _texts(folder: Path, files_: Mapping[str, str], names: Mapping[str, str]) -> dict[Path, str]:
    return {folder / Template(name).substitute(names): _text(template, names) for template, name in files_.items()}


def _write(folder: Path, texts: Mapping[Path, str]) -> None:
    if taken := [path for path in texts if path.exists()]:
        raise UsageError(f"{taken[0]} exists; give another folder")
    try:
        for path, text in texts.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
    except OSError as exc:
        raise UsageError(f"{folder} cannot be written: {exc.strerror}") from exc
    print(f"created {folder.name} with {', '.join(str(path.relative_to(folder)) for path in texts)}")


def _integration_name(folder: str) -> str:
    name = re.sub(r"\W+", "_", folder.lower(), flags=re.ASCII).strip("_").removeprefix("homebot_")
    if not name.isidentifier() or not _kind(name).isidentifier() or keyword.iskeyword(_kind(name)):
        raise UsageError(f"an integration cannot be named after the folder {folder!r}; use letters, such as acme")
    if any(has_plugin(group, name) for group in _GROUPS) or importlib.util.find_spec(f"homebot_{name}") is not None:
        raise UsageError(f"there is an integration {name!r} already; give the folder another name, such as my_{name}")
    return name


def _module_name(folder: str) -> str:
    name = re.sub(r"\W+", "_", folder.lower(), flags=re.ASCII).strip("_")
    if not name.isidentifier() or keyword.iskeyword(name):
        raise UsageError(f"an app cannot be named after the folder {folder!r}; use letters, such as hall_light")
    if importlib.util.find_spec(name) is not None:
        raise UsageError(f"there is a module {name!r} already; give the folder another name, such as my_{name}")
    return name


def _text(template: str, names: Mapping[str, str]) -> str:
    return Template((files("homebot.cli") / "templates" / template).read_text(encoding="utf-8")).substitute(names)
