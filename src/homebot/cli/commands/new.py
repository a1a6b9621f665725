"""``homebot new``."""

import argparse
import importlib.util
import keyword
import re
import shlex
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Final

from homebot.cli.arguments import set_command
from homebot.cli.commands.service import unit_text
from homebot.errors import UsageError

__all__ = ["add_arguments"]

_EXAMPLES = """\
  homebot new hall_light          hall_light/ with an app HallLight, its test, configuration, house and service
  cd hall_light && pytest && homebot config check && homebot run --house house.toml
"""

_FILES: Final = {
    "app.py.template": "$module.py",
    "test.py.template": "test_$module.py",
    "pytest.ini.template": "pytest.ini",
    "homebot.toml.template": "homebot.toml",
    "house.toml.template": "house.toml",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_command(parser, _new, _EXAMPLES)
    parser.add_argument("folder", metavar="FOLDER", help="folder to create; the app is named after it")


def _new(options: argparse.Namespace) -> int:
    folder = Path(options.folder).resolve()
    module = _module_name(folder.name)
    names = {"module": module, "kind": "".join(word.capitalize() for word in module.split("_"))}
    texts = {folder / Template(name).substitute(names): _text(template, names) for template, name in _FILES.items()}
    texts[folder / f"{module}.service"] = unit_text(folder / "homebot.toml", is_user=True)
    if taken := [path for path in texts if path.exists()]:
        raise UsageError(f"{taken[0]} exists; give another folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for path, text in texts.items():
            path.write_text(text, encoding="utf-8")
    except OSError as exc:
        raise UsageError(f"{folder} cannot be written: {exc.strerror}") from exc
    print(f"created {options.folder} with {', '.join(path.name for path in texts)}")
    there = shlex.quote(str(options.folder))
    print(f"try it: cd {there} && pytest && homebot config check && homebot run --house house.toml")
    return 0


def _module_name(folder: str) -> str:
    name = re.sub(r"\W+", "_", folder.lower(), flags=re.ASCII).strip("_")
    if not name.isidentifier() or keyword.iskeyword(name):
        raise UsageError(f"an app cannot be named after the folder {folder!r}; use letters, such as hall_light")
    if importlib.util.find_spec(name) is not None:
        raise UsageError(f"there is a module {name!r} already; give the folder another name, such as my_{name}")
    return name


def _text(template: str, names: dict[str, str]) -> str:
    return Template((files("homebot.cli") / "templates" / template).read_text(encoding="utf-8")).substitute(names)
