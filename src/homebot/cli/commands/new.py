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
from homebot.cli.main import all_commands
from homebot.devices.own_services import own_namespaces
from homebot.errors import UsageError
from homebot.feature import find_features
from homebot.plugins import has_plugin

_EXAMPLES = """\
  homebot new hall_light          hall_light/ with an app HallLight, its test, configuration, house and service
  cd hall_light && pytest && homebot config check && homebot run --house house.toml
  homebot new integration acme    acme/ with a package homebot_acme: messages on MQTT, simulated devices, tests
  cd acme && pip install -e . && pytest && homebot run --house house.toml
  homebot new feature lit         lit/ with a package homebot_lit: a node, a service, a command, a test
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
_FEATURE: Final = {
    "feature/package.py.template": "$module/__init__.py",
    "feature/server.py.template": "$module/server.py",
    "feature/command.py.template": "$module/command.py",
    "feature/test_feature.py.template": "test_feature.py",
    "feature/pyproject.toml.template": "pyproject.toml",
    "feature/homebot.toml.template": "homebot.toml",
    "feature/house.toml.template": "house.toml",
}
_PACKAGES: Final = {"integration": _INTEGRATION, "feature": _FEATURE}
_GROUPS: Final = ("homebot.mqtt_conventions", "homebot.simulated")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_command(parser, _new, _EXAMPLES)
    parser.add_argument(
        "kind",
        nargs="?",
        choices=(*_PACKAGES,),
        help="a package for devices, or one with a feature; without it, an app",
    )
    parser.add_argument("folder", metavar="FOLDER", help="folder to create; what is in it is named after it")


def _new(options: argparse.Namespace) -> int:
    folder = Path(options.folder).resolve()
    if options.kind is None and options.folder in _PACKAGES:
        raise UsageError(f"{_with_article(options.folder)} needs a name: homebot new {options.folder} NAME")
    if options.kind is None:
        module = _module_name(folder.name)
        names = {"module": module, "kind": _kind(module)}
        others = {folder / f"{module}.service": unit_text(folder / "homebot.toml", is_user=True)}
        _write(folder, _texts(folder, _APP, names) | others)
        steps = "pytest && homebot config check"
    else:
        name = _package_name(folder.name, options.kind)
        names = {"name": name, "module": f"homebot_{name}", "kind": _kind(name)}
        _write(folder, _texts(folder, _PACKAGES[options.kind], names))
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


def _package_name(folder: str, kind: str) -> str:
    what, name = _with_article(kind), re.sub(r"\W+", "_", folder.lower(), flags=re.ASCII).strip("_")
    name = name.removeprefix("homebot_")
    if not name.isidentifier() or not _kind(name).isidentifier() or keyword.iskeyword(_kind(name)):
        raise UsageError(f"{what} cannot be named after the folder {folder!r}; use letters, such as acme")
    is_taken = _is_integration(name) if kind == "integration" else _is_offered(name)
    if is_taken or importlib.util.find_spec(f"homebot_{name}") is not None:
        raise UsageError(f"there is {what} {name!r} already; give the folder another name, such as my_{name}")
    return name


def _is_integration(name: str) -> bool:
    """Return whether homebot or another package has an integration of the name."""
    is_own = importlib.util.find_spec(f"homebot.integrations.{name}") is not None
    return is_own or any(has_plugin(group, name) for group in _GROUPS)


def _is_offered(name: str) -> bool:
    """Return whether a feature, a command or a part of homebot has the name."""
    return name in find_features().features or name in all_commands() or name in own_namespaces()


def _with_article(kind: str) -> str:
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"


def _module_name(folder: str) -> str:
    name = re.sub(r"\W+", "_", folder.lower(), flags=re.ASCII).strip("_")
    if not name.isidentifier() or keyword.iskeyword(name):
        raise UsageError(f"an app cannot be named after the folder {folder!r}; use letters, such as hall_light")
    if importlib.util.find_spec(name) is not None:
        raise UsageError(f"there is a module {name!r} already; give the folder another name, such as my_{name}")
    return name


def _text(template: str, names: Mapping[str, str]) -> str:
    return Template((files("homebot.cli") / "templates" / template).read_text(encoding="utf-8")).substitute(names)
