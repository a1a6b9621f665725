"""The arguments of the marks ``house`` and ``homebot``, and the house that they describe."""

from asyncio import AbstractEventLoop
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager, contextmanager
from copy import deepcopy
from pathlib import Path
from typing import Any, Final, TypeVar, cast

import pytest

from homebot.config import Config, load_config, parse_config
from homebot.errors import UsageError
from homebot.house import World, thesis_world
from homebot.house.description import load_world
from homebot.testing.contexts import hold_open
from homebot.testing.event_log import EventLog, house_report
from homebot.testing.house import TestHouse, house_of
from homebot.testing.loop_guard import LoopGuard
from homebot.testing.virtual_house import VirtualHouse, parse_time, virtual_house_of
from homebot.units import parse_duration

ALLOW_CRASHES: Final = "allow_crashes"
HOUSE: Final = frozenset({"world", "config", "root", "start", "seed", "heartbeat", ALLOW_CRASHES})
HOMEBOT: Final = frozenset({"config", "root", ALLOW_CRASHES})

ValueT = TypeVar("ValueT")


def house_of_test(
    test: pytest.Item,
    fixture: str,
    loop: AbstractEventLoop,
    reports: list[Callable[[], tuple[str, str]]],
    has_failed: Callable[[], bool],
    *config: object,
) -> Iterator[TestHouse]:
    """Yield the house of *test*, and fail it afterwards for an app that crashed, blocked, or names what is not there.

    Args:
        reports: Gets the function for the title and the text about the house.
    """
    with LoopGuard(loop) as guard, _open_house(test, loop, *config) as house:
        reports.append(lambda: (f"what happened in `{fixture}`", house_report(house)))
        yield house
        if _arguments(test, fixture).get(ALLOW_CRASHES) is True or has_failed():
            return
        problems = [f"{name} crashed" for name in house.crashed]  # it was restarted, which the test may not notice
        problems += [
            f"{place} blocked the event loop: make it await, or run it in a thread" for place in guard.blocked_by
        ]
        problems += loop.run_until_complete(house.misspelt_names())
        if problems:
            mark = f"@pytest.mark.{fixture}(allow_crashes=True)"
            pytest.fail(f"{'; '.join(problems)}; where that is meant, {mark}", pytrace=False)


@contextmanager
def _open_house(test: pytest.Item, loop: AbstractEventLoop, *config: object) -> Iterator[TestHouse]:
    """Run and log the homebot or the house that the marks of *test* describe, on *loop*.

    The marks of the function take precedence over those of class and module; apps come from the nearest mark with any.
    An invalid mark fails the test with a message that names the argument, without homebot's code in the traceback.
    """
    try:
        with hold_open(loop, _with_log(_homebot(test, *config) if config else _virtual_house(test))) as house:
            yield house
    except UsageError as exc:
        raise pytest.fail.Exception(str(exc), pytrace=False) from None


@asynccontextmanager
async def _with_log(made: AbstractAsyncContextManager[TestHouse]) -> AsyncIterator[TestHouse]:
    async with made as house, EventLog.of(house):
        yield house


def _virtual_house(test: pytest.Item) -> AbstractAsyncContextManager[VirtualHouse]:
    apps, arguments = _read(test, "house", HOUSE)
    seed = arguments.get("seed")
    world = _check("house", "world", arguments.get("world", thesis_world), lambda value: _world(value, test, seed))
    config = _check("house", "config", arguments.get("config", {}), lambda value: _config(value, test))
    return virtual_house_of(*apps, **(arguments | {"world": world, "config": config}))


def _homebot(test: pytest.Item, config: object) -> AbstractAsyncContextManager[TestHouse]:
    apps, arguments = _read(test, "homebot", HOMEBOT)
    given = _check("homebot", "config", config, lambda value: _config(value, test))
    return house_of(*apps, **(arguments | {"config": given}))


def config_of(test: pytest.Item) -> object:
    """Return the argument ``config`` of the marks of *test*."""
    return _arguments(test, "homebot").get("config", {})


def _read(test: pytest.Item, name: str, known: frozenset[str]) -> tuple[list[str], dict[str, Any]]:
    arguments = _arguments(test, name)
    unknown = sorted(set(arguments) - known)
    if unknown:
        raise UsageError(f"{_where(name, unknown[0])} is unknown; known are {', '.join(sorted(known))}")
    named = next((mark.args for mark in test.iter_markers(name) if mark.args), ())
    apps = [_check(name, f"app {number}", app, _app) for number, app in enumerate(named, 1)]
    checked = {key: _check(name, key, value, _CHECKS.get(key, _same)) for key, value in arguments.items()}
    return apps, {key: value for key, value in checked.items() if key != ALLOW_CRASHES}


def _arguments(test: pytest.Item, name: str) -> dict[str, Any]:
    """Return the arguments of all marks of this *name*; those nearer to the test take precedence."""
    return {key: value for mark in reversed(list(test.iter_markers(name))) for key, value in mark.kwargs.items()}


def _check(mark: str, argument: str, value: object, check: Callable[[Any], ValueT]) -> ValueT:
    try:
        return check(value)
    except UsageError as exc:
        raise UsageError(f"{_where(mark, argument)}: {exc}") from exc


def _where(mark: str, argument: str) -> str:
    return f"@pytest.mark.{mark}, {argument}"


def _same(value: object) -> object:
    return value


def _app(app: object) -> str:
    if isinstance(app, type):
        return f"{app.__module__}:{app.__qualname__}"
    if isinstance(app, str):
        return app
    raise UsageError(f"{app!r} is not an app: give a plug-in's name, module:Class, or the class")


def _text(value: object) -> str:
    if isinstance(value, str) and value:
        return value
    raise UsageError(f"{value!r} is not text")


def _yes_or_no(value: object) -> bool:
    if isinstance(value, bool):
        return value
    raise UsageError(f"{value!r} is neither True nor False")


def _seed(value: object) -> int:
    if isinstance(value, int):
        return value
    raise UsageError(f"{value!r} is not a whole number")


def _heartbeat(value: object) -> float:
    seconds = parse_duration(value) if isinstance(value, str | int | float) else 0.0
    if seconds > 0:
        return seconds
    raise UsageError(f"{value!r} is not a heartbeat interval; write it like 5m, or seconds")


_CHECKS: Final[Mapping[str, Callable[[Any], object]]] = {
    "root": _text,
    "seed": _seed,
    "start": parse_time,
    "heartbeat": _heartbeat,
    ALLOW_CRASHES: _yes_or_no,
}


def _world(value: object, test: pytest.Item, seed: int | None) -> World:
    """Return a separate world for this test, even if several tests share the mark."""
    if isinstance(value, str | Path):
        return load_world(_beside(test, value), seed=seed)
    made = value() if callable(value) else deepcopy(value)
    if isinstance(made, World):
        return made
    raise UsageError(f"{value!r} is not a house: give a TOML file, a World, or a function that returns one")


def _config(value: object, test: pytest.Item) -> Config:
    if isinstance(value, Config):
        return value
    if isinstance(value, str | Path):
        return load_config(_beside(test, value))
    if isinstance(value, Mapping):
        return parse_config(cast("Mapping[str, object]", value), "tables")
    raise UsageError(f"{value!r} is not a configuration: give tables, as in homebot.toml, or such a file")


def _beside(test: pytest.Item, path: str | Path) -> Path:
    return test.path.parent / path
