"""Plug-ins: classes found by entry-point name, or written out as ``module:Class`` or ``FILE.py:Class``; extras."""

import importlib
import importlib.util
import itertools
import os
import re
import stat
import sys
import traceback
from collections.abc import Iterable, Iterator, Mapping, MutableMapping
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import Distribution, EntryPoint, PackageNotFoundError, distribution, entry_points
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from homebot.errors import PluginError, UsageError
from homebot.names import snake_case
from homebot.support.file_access import why_not_trusted
from homebot.support.names import did_you_mean

_Groups = Mapping[str, tuple[EntryPoint, ...]]

_OWN: Final = tuple(Path(__file__).with_name(name) for name in ("features", "integrations"))
"""The folders of which each folder may have plug-ins of its own."""

_LOADERS: Final = {Path(__file__), Path(importlib.__file__), Path(importlib.metadata.__file__)}
"""The files of Python and homebot that import plug-ins."""

INSTALL_EXTRA: Final = 'pip install "homebot['
"""The beginning of the command to install an extra."""

_FILE: Final = re.compile(r"(?P<file>.+\.py)(?::(?P<kind>\w+))?")


def plugin_names(group: str) -> tuple[str, ...]:
    """Return the names that the entry-point group *group* offers, sorted."""
    return tuple(sorted({point.name for point in _entry_points(tuple(sys.path)).get(group, ())}))


def own_plugin_names(group: str) -> tuple[str, ...]:
    """Return the names that homebot itself offers in the entry-point group *group*, sorted."""
    return tuple(sorted(point.name for point in _own_entry_points(tuple(sys.path)).get(group, ())))


def entry_points_of_others(group: str) -> tuple[EntryPoint, ...]:
    """Return the entry points that other packages offer in *group*, sorted.

    Their files are searched for its name first: reading them all takes ten times as long.
    """
    wanted = f"[{group}]".encode()
    if not any(wanted in file.read_bytes() for folder in sys.path for file in _files_of_entry_points(folder)):
        return ()
    own = _own_entry_points(tuple(sys.path)).get(group, ())
    return tuple(sorted(point for point in _entry_points(tuple(sys.path)).get(group, ()) if point not in own))


def _files_of_entry_points(folder: str) -> Iterator[Path]:
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            file = Path(entry.path, "entry_points.txt")
            if entry.name.endswith(".dist-info") and file.is_file():
                yield file


def has_plugin(group: str, name: str) -> bool:
    """Return whether the entry-point group *group* offers *name*."""
    return _entry_point(group, name) is not None


def load_plugin(group: str, name: str) -> type[Any]:
    """Return the plug-in class *name*.

    Args:
        group: The entry-point group, for example ``homebot.apps``.
        name: A name in that group, ``module:Class`` or ``FILE.py:Class``. If two packages offer a name, homebot's own
            is used. A module that is not installed is looked for in the working directory.

    Raises:
        PluginError: There is no such plug-in, importing it fails, it is not a class, or it is in a file or folder that
            others may write to.
    """
    if is_file(name):
        plugin = _load_from_file(name)
    else:
        plugin = _load_class(name) if ":" in name else _load_entry_point(group, name)
    if not isinstance(plugin, type):
        raise PluginError(name, f"is {plugin!r}, not a class")
    return plugin


def plugin_path(group: str, name: str) -> str:
    """Return *name*, as for :func:`load_plugin`, as ``module:Class`` or as its file.

    Raises:
        PluginError: It is not installed.
    """
    return name if ":" in name or is_file(name) else _find_installed(group, name).value


def installed_plugin(group: str, kind: str) -> type[Any] | None:
    """Return the class *kind*, as ``module:Class``, of the entry-point group *group*; None if no entry point offers it.

    Nothing else is loaded, so *kind* may come from an untrusted source.
    """
    for name in plugin_names(group):
        with suppress(PluginError):
            offered: type[Any] = load_plugin(group, name)
            if kind == f"{offered.__module__}:{offered.__qualname__}":
                return offered
    return None


def is_file(name: str) -> bool:
    """Return whether *name* refers to a plug-in by file, ``FILE.py`` or ``FILE.py:Class``."""
    return _FILE.fullmatch(name) is not None


def name_in_file(name: str, base: type[object]) -> str:
    """Return the file *name* as ``FILE.py:Class``, adding its only class if *name* has none.

    Raises:
        PluginError: As for :func:`load_plugin`; or the file has no class, or several.
    """
    path, class_name = file_and_class(name)
    return name if class_name is not None else f"{name}:{class_in(_module_in(path, name), name, base)}"


def class_in(module: ModuleType, name: str, base: type[object]) -> str:
    """Return the name of the only class in *module*, the file *name*, that is derived from *base*.

    Raises:
        PluginError: It has no such class, or several.
    """
    kinds = [text for text, kind in vars(module).items() if _is_own(kind, base, module)]
    if len(kinds) != 1:
        has = f"has {', '.join(kinds)}" if kinds else f"has no class of its own that is derived from {base.__name__}"
        raise PluginError(name, f"must be one class, FILE.py or FILE.py:CLASS; the file {has}")
    return kinds[0]


def add_app(apps: MutableMapping[str, dict[str, object]], wanted: str) -> None:
    """Add *wanted* to the tables *apps* unless one has it; a class MyApp becomes my_app, with the settings there."""
    if app_of(apps, wanted):
        return
    kind = wanted.rpartition(":")[2]
    first = name = snake_case(kind) if ":" in wanted else wanted
    number = 1
    while name in apps and ("class" in apps[name] or has_plugin("homebot.apps", name)):
        number += 1
        name = f"{first}_{number}"
    apps[name] = apps.get(name, {}) | ({} if name == wanted else {"class": wanted})


def app_of(apps: Mapping[str, Mapping[str, object]], wanted: str) -> str:
    """Return the name in the tables *apps* of the app that :func:`add_app` adds for *wanted*; empty for none."""
    return next((name for name, table in apps.items() if _is_same(str(table.get("class", name)), wanted)), "")


def _is_same(one: str, other: str) -> bool:
    (place, kind), (other_place, other_kind) = _place_of(one), _place_of(other)
    is_there = place == other_place or (place.name == other_place.name and place.absolute() == other_place.absolute())
    return kind == other_kind and is_there


def _place_of(name: str) -> tuple[Path, str]:
    """Return the file that contains ``module:Class`` or ``FILE.py:Class``, and the rest of *name*."""
    module, _, kind = name.rpartition(":")
    return Path(module if module.endswith(".py") else f"{module.replace('.', '/')}.py"), kind


def check_extra(what: str, extra: str, *modules: str) -> None:
    """Check, without importing, that the libraries of an extra such as ``homebot[mdns]`` are installed.

    Args:
        what: The feature, as text: ``the gateway "mdns"``.

    Raises:
        UsageError: A library is missing; names the command that installs it.
    """
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    if missing:
        raise UsageError(f'{what} needs {", ".join(missing)}; install it with: {INSTALL_EXTRA}{extra}]"')


def _load_entry_point(group: str, name: str) -> object:
    point = _find_installed(group, name)
    try:
        return point.load()
    except (Exception, SystemExit) as exc:
        raise PluginError(name, f"cannot be loaded: {error_text(exc)}") from exc


def _find_installed(group: str, name: str) -> EntryPoint:
    if (point := _entry_point(group, name)) is not None:
        return point
    known = plugin_names(group)
    raise PluginError(name, f"is not installed (installed: {', '.join(known) or 'none'}); {_hint(name, known)}")


def _entry_point(group: str, name: str) -> EntryPoint | None:
    """Return the plug-in *name*; the files of other packages are read only if homebot has none of that name."""
    path = tuple(sys.path)
    for groups in (_own_entry_points, _entry_points):
        for point in groups(path).get(group, ()):
            if point.name == name:
                return point
    return None


@lru_cache(maxsize=1)
def _own_entry_points(path: tuple[str, ...]) -> _Groups:
    """Return the groups of homebot itself: of features, integrations, and its package if that is on Python's *path*."""
    del path  # only the key of the cache
    files = [file for folder in _OWN for file in sorted(folder.glob("*/entry_points.txt"))]
    points = [point for file in files for point in Distribution.at(file.parent).entry_points]
    with suppress(PackageNotFoundError):
        points += distribution("homebot").entry_points
    return _groups(points)


@lru_cache(maxsize=1)
def _entry_points(path: tuple[str, ...]) -> _Groups:
    """Return homebot's groups in all packages on *path*: reading a single group would read all files too."""
    own, installed = _own_entry_points(path), entry_points()
    others = [point for group in installed.groups for point in installed.select(group=group)]
    return _groups((*itertools.chain(*own.values()), *others))


def _groups(points: Iterable[EntryPoint]) -> _Groups:
    groups: dict[str, tuple[EntryPoint, ...]] = {}
    for point in points:
        if point.group.startswith("homebot."):
            groups[point.group] = (*groups.get(point.group, ()), point)
    return groups


def _hint(name: str, known: tuple[str, ...]) -> str:
    """Return a suggestion for *name*: add the class to a module, or use a similar plug-in."""
    if name.isidentifier() and (Path(f"{name}.py").exists() or _is_installed(name)):
        return f"did you mean {name}:CLASS, with the name of a class in that module?"
    for group, points in _own_entry_points(tuple(sys.path)).items():
        owner, _, kind = group.removeprefix("homebot.").partition("_")
        if kind and any(point.name == name for point in points):
            return f"it is one of the {kind} of {owner}: the table [gateways.{owner}] is enough"
    otherwise = 'write class = "NAME" for one more of these, or class = "module:Class" for your own'
    return did_you_mean(name, known, otherwise, cutoff=0.6)


def _load_class(path: str) -> object:
    module_name, _, class_name = path.partition(":")
    try:
        if not _is_installed(module_name):
            _look_here_too(path, module_name)
        module = importlib.import_module(module_name)
    except PluginError:
        raise
    except (Exception, SystemExit) as exc:
        raise PluginError(
            path, f"cannot be loaded: the module {module_name!r} cannot be imported: {error_text(exc)}"
        ) from exc
    try:
        return getattr(module, class_name)
    except AttributeError:
        problem = _missing_class(f"the module {module_name!r} has no {class_name!r}", class_name, module)
        raise PluginError(path, problem) from None


def _load_from_file(name: str) -> object:
    path, class_name = file_and_class(name)
    if class_name is None:
        raise PluginError(name, "must be FILE.py:CLASS, with the name of a class in that file")
    try:
        return getattr(_module_in(path, name), class_name)
    except AttributeError:
        problem = _missing_class(f"the file has no {class_name!r}", class_name, _module_in(path, name))
        raise PluginError(name, problem) from None


def file_and_class(name: str) -> tuple[Path, str | None]:
    """Return the file and the class of *name*, ``FILE.py`` or ``FILE.py:Class``; None without a class."""
    match = _FILE.fullmatch(name)
    assert match is not None  # noqa: S101 - for the type checker: the callers know it
    return Path(match["file"]), match["kind"]


def _is_own(kind: object, base: type[object], module: ModuleType) -> bool:
    return isinstance(kind, type) and issubclass(kind, base) and kind.__module__ == module.__name__


def _module_in(path: Path, name: str) -> ModuleType:
    """Return *path* as a module, which is run again only if the file changes."""
    check_file(path, name)
    try:
        return _run_as_module(path.resolve(), path.stat().st_mtime_ns)
    except (Exception, SystemExit) as exc:
        raise PluginError(name, f"cannot be loaded: {error_text(exc)}") from exc


def check_file(path: Path, name: str) -> None:
    """Check that the file of the plug-in *name* exists, and that others may not write to it.

    Raises:
        PluginError: The file is missing, or others may write to it.
    """
    if not path.is_file():
        raise PluginError(name, f"cannot be loaded: there is no file {path}")
    if problem := why_not_trusted(path):
        raise PluginError(name, f"is not loaded: {problem}")


def module_name_of(file: Path) -> str:
    """Return the name of *file* as a module: its own, or a longer one if another module has that name."""
    name = re.sub(r"\W", "_", file.stem)
    return name if _file_of_module(name) in {None, str(file)} else f"file_{name}"


@lru_cache(maxsize=64)
def _run_as_module(file: Path, _changed_at: int) -> ModuleType:
    """Run *file* as a module.

    Afterwards the modules in its folder can be imported; a plug-in among them is then the same module.
    """
    look_in(file.parent)
    return run_file(module_name_of(file), file)


def run_file(name: str, file: Path) -> ModuleType:
    """Run *file* as the module *name*, and register it unless it fails."""
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None  # noqa: S101 - for the type checker: its name ends with .py
    assert spec.loader is not None  # noqa: S101 - as above
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def _missing_class(problem: str, name: str, module: ModuleType) -> str:
    """Return the error for a missing class *name* in *module*, with suggestions."""
    own = [class_name for class_name, kind in vars(module).items() if _is_own(kind, object, module)]
    similar = did_you_mean(name, own, "")
    return f"cannot be loaded: {problem}{'; ' if similar else ''}{similar}"


def _is_installed(module_name: str) -> bool:
    package = module_name.partition(".")[0]
    return package in sys.modules or importlib.util.find_spec(package) is not None


def _file_of_module(name: str) -> str | None:
    """Return the file of the module *name*: empty if it has none, None if there is no such module."""
    if (module := sys.modules.get(name)) is not None:
        return getattr(module, "__file__", None) or ""
    spec = importlib.util.find_spec(name)
    return None if spec is None else spec.origin or ""


def _look_here_too(path: str, module_name: str) -> None:
    """Search the working directory for modules, after all others, if only its owner can write there."""
    here = Path.cwd()
    package = here / module_name.partition(".")[0]
    for place in (here, package.with_suffix(".py"), package, package / "__init__.py"):
        problem = why_not_trusted(place) if place.exists() else ""
        if not problem and place == here and here.stat().st_mode & stat.S_IWOTH:
            problem = f"everyone may write to {here}"
        if problem:
            raise PluginError(path, f"is not loaded from the working directory: {problem}")
    look_in(here)


def look_in(folder: Path) -> None:
    """Search *folder* for modules, after all others."""
    if str(folder) not in sys.path:
        sys.path.append(str(folder))
    importlib.invalidate_caches()


def error_text(error: Exception | SystemExit) -> str:
    """Return *error* with the line of the plug-in that raised it; a syntax error has its own line."""
    traced = ((Path(frame.f_code.co_filename), line) for frame, line in traceback.walk_tb(error.__traceback__))
    own = [f" ({file.name}, line {line})" for file, line in traced if file not in _LOADERS and file.exists()]
    line = own[0] if own and not isinstance(error, SyntaxError) else ""
    if isinstance(error, SystemExit):
        return f'it calls sys.exit(){line}; a program begins below `if __name__ == "__main__":`'
    return f"{type(error).__name__}: {error}{line}"
