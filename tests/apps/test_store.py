"""Values of apps: JSON by key, over a restart, a crash and a damaged file; bounded."""

import json
import random
import shutil
import sqlite3
import subprocess
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, closing
from pathlib import Path
from types import MappingProxyType
from typing import Any

import anyio
import pytest
from structlog.testing import capture_logs
from tests.damage import damage
from tests.patience import PATIENCE
from tests.sizes import size

from homebot.apps import App, NoSettings
from homebot.apps.store import MAX_BYTES, MAX_KEYS, MAX_VALUE_BYTES, Store
from homebot.apps.stores import WRITE_AFTER, AppStores
from homebot.clock import ManualClock
from homebot.config import parse_config
from homebot.errors import UsageError
from homebot.graph import Graph, Node
from homebot.runtime import Runtime
from homebot.runtime.app_host import STORE_FILE


@asynccontextmanager
async def opened(path: Path) -> AsyncIterator[AppStores]:
    stores = AppStores(path, ManualClock(1_800_000_000.0))
    if path.exists():
        await stores.read()
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(stores.run)
        yield stores
        tasks.cancel_scope.cancel()
    await stores.close()


def rows(path: Path) -> dict[tuple[str, str], Any]:
    """Return what is in a file that another program may hold."""
    with closing(sqlite3.connect(f"file:{path}?immutable=1", uri=True)) as connection:
        return {(app, key): json.loads(value) for app, key, value in connection.execute("SELECT * FROM store")}


@pytest.mark.parametrize(
    "value", ["away", 22.5, 3, True, None, ["hall", {"lamp": [1, 2]}], {"until": "2026-11-23"}, "\ud800 ünïcode"]
)
async def test_each_json_value_is_there_after_a_restart(tmp_path: Path, value: object) -> None:
    async with opened(tmp_path / STORE_FILE) as stores:
        stores.of("hall")["value"] = value
        assert stores.of("hall")["value"] == value
    async with opened(tmp_path / STORE_FILE) as stores:
        assert dict(stores.of("hall")) == {"value": value}
        assert dict(stores.of("kitchen")) == {}


async def test_what_was_removed_is_gone_after_a_restart(tmp_path: Path) -> None:
    async with opened(tmp_path / STORE_FILE) as stores:
        stores.of("hall").update(one=1, two=2)
        await stores.flush()
        del stores.of("hall")["one"]
        stores.of("hall")["short"] = "lived"
        del stores.of("hall")["short"]
        assert len(stores._changed) == 1  # what came and went is not waiting to be written
    async with opened(tmp_path / STORE_FILE) as stores:
        store = stores.of("hall")
        assert dict(store) == {"two": 2}
        assert store.get("one") is None
        with pytest.raises(KeyError):
            del store["one"]


def test_a_value_is_copied_when_it_is_stored() -> None:
    store = Store("hall")
    rooms = ["hall"]
    store["rooms"] = rooms
    rooms.append("kitchen")
    assert store["rooms"] == ["hall"]


def set_item(value: Any, key: object, new: object) -> object:
    value[key] = new
    return new


CHANGES: dict[str, Callable[[Any], object]] = {
    "append": lambda it: it["log"].append(4),
    "extend": lambda it: it["log"].extend([4, [5]]),
    "insert and remove": lambda it: (it["log"].insert(0, 9), it["log"].remove(2)),
    "pop": lambda it: it["log"].pop(),
    "sort and reverse": lambda it: (it["log"].sort(), it["log"].reverse()),
    "clear": lambda it: it["log"].clear(),
    "an item": lambda it: set_item(it["log"], 0, 7),
    "a slice": lambda it: set_item(it["log"], slice(0, 2), [{"a": 1}]),
    "an item of a dict in a list in a dict": lambda it: set_item(it["deep"]["lamps"][0], "on", True),
    "what was put in before": lambda it: (it["deep"].update(new=[]), it["deep"]["new"].append({}))[1],
    "what a list was set to": lambda it: (it["log"].append([]), it["log"][-1].append(1))[1],
    "setdefault": lambda it: it["deep"].setdefault("seen", []).append("hall"),
    "setdefault of the store": lambda it: it.setdefault("seen", []).append("hall"),
    "popitem": lambda it: it["deep"].popitem(),
    "update": lambda it: it["deep"].update({"x": {"y": 1}}, z=2),
    "the old way": lambda it: (log := it["log"], log.append(4), set_item(it, "log", log)),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
async def test_a_change_of_what_was_read_is_stored(tmp_path: Path, change: Callable[[Any], object]) -> None:
    """It was lost in silence: the value was a copy."""
    plain: dict[str, Any] = {"log": [3, 1, 2], "deep": {"lamps": [{"on": False}], "n": 1}}
    async with opened(tmp_path / STORE_FILE) as stores:
        stores.of("hall").update(plain)
    change(plain)
    async with opened(tmp_path / STORE_FILE) as stores:
        change(stores.of("hall"))
        assert dict(stores.of("hall")) == plain
    async with opened(tmp_path / STORE_FILE) as stores:
        assert dict(stores.of("hall")) == plain


@pytest.mark.parametrize(("text", "kind", "unchanging"), [("[1]", list, tuple), ('{"n": 1}', dict, MappingProxyType)])
def test_every_method_that_changes_a_list_or_dict_stores_it(text: str, kind: type, unchanging: type) -> None:
    """Python may get more of them."""
    of_both = {*dir(unchanging), "__reversed__", "__init__", "fromkeys", "copy"}
    assert set(dir(kind)) - of_both <= set(vars(type(Store("hall", {"key": text})["key"])))


def test_two_readers_of_one_value_do_not_undo_each_other() -> None:
    store = Store("hall")
    store["log"] = []
    one, two = store["log"], store["log"]
    one.append(1)
    two.append(2)
    assert store["log"] == [1, 2]


def test_a_value_that_was_replaced_changes_nothing_any_more() -> None:
    store = Store("hall")
    store["log"] = [1]
    old = store["log"]
    store["log"] = [2]
    old.append(3)
    assert store["log"] == [2]
    old = store["log"]
    del store["log"]
    old.append(3)
    assert "log" not in store


def test_a_change_that_cannot_be_stored_is_an_error_and_undone() -> None:
    store = Store("hall")
    store["log"] = [1]
    with pytest.raises(UsageError, match=r"store\['log'\] takes text, numbers"):
        store["log"].append({1, 2})
    with pytest.raises(UsageError, match="a value takes at most"):
        store["log"].append("x" * MAX_VALUE_BYTES)
    assert store["log"] == [1]


def test_keys_of_homebot_are_not_listed() -> None:
    store = Store("hall")
    store["_timers"] = {"off": 12.5}
    store["armed"] = True
    assert (list(store), len(store), store["_timers"]) == (["armed"], 1, {"off": 12.5})
    store.clear()
    assert (list(store), store["_timers"]) == ([], {"off": 12.5})
    assert repr(store) == "<store of hall: empty>"


@pytest.mark.parametrize(
    ("key", "value", "problem"),
    [
        ("", 1, "a key of the store is a printable text of 1 to 200 characters, got ''"),
        ("k" * 201, 1, "a key of the store is"),
        ("a\nb", 1, "a key of the store is"),
        (7, 1, "a key of the store is a printable text of 1 to 200 characters, got 7"),
        ("lamp", {1, 2}, r"hall: store\['lamp'\] takes text, numbers, .* got {1, 2}: Object of type set"),
        ("lamp", float("nan"), "Out of range float"),
        ("lamp", "x" * MAX_VALUE_BYTES, "a value takes at most 65,536 bytes as JSON, got 65,538"),
    ],
)
def test_what_is_no_json_or_too_large_is_an_error_that_names_it(key: Any, value: object, problem: str) -> None:
    store = Store("hall", {"lamp": "1"})
    with pytest.raises(UsageError, match=problem):
        store[key] = value
    assert dict(store) == {"lamp": 1}


def test_an_app_keeps_no_more_than_its_share() -> None:
    store = Store("hall")
    for number in range(MAX_KEYS):
        store[f"key {number}"] = "x"
    with pytest.raises(UsageError, match=r"hall: store\['more'\]: an app has at most 1,000 keys; remove some first"):
        store["more"] = 1
    for number in range(MAX_BYTES // MAX_VALUE_BYTES - 1):
        store[f"key {number}"] = "x" * (MAX_VALUE_BYTES - 2)
    with pytest.raises(UsageError, match="the values of an app take at most 1,048,576 bytes, and the others take"):
        store["key 999"] = "x" * (MAX_VALUE_BYTES - 2)
    del store["key 0"]
    store["key 999"] = "x" * (MAX_VALUE_BYTES - 2)


async def test_changes_are_written_together_five_seconds_later(
    tmp_path: Path, pass_time: Callable[[float], None]
) -> None:
    path = tmp_path / STORE_FILE
    async with opened(path) as stores:
        for number in range(100):
            stores.of("hall")["number"] = number
        await anyio.wait_all_tasks_blocked()
        assert not path.exists()
        pass_time(WRITE_AFTER)
        with anyio.fail_after(PATIENCE):
            while stores._changed:  # noqa: ASYNC110 - it is written by a thread
                await anyio.sleep(0.01)
        assert path.exists()
    assert rows(path) == {("hall", "number"): 99}


async def test_the_same_value_again_is_no_change(tmp_path: Path) -> None:
    """A disk wears out by what is written."""
    async with opened(tmp_path / STORE_FILE) as stores:
        stores.of("hall")["armed"] = True
        await stores.flush()
        stores.of("hall")["armed"] = True
        assert not stores._changed


async def test_a_damaged_file_is_set_aside(tmp_path: Path) -> None:
    path = tmp_path / STORE_FILE
    path.write_bytes(b"no database at all" * 100)
    path.chmod(0o600)
    with capture_logs() as lines:
        async with opened(path) as stores:
            assert dict(stores.of("hall")) == {}
            stores.of("hall")["armed"] = True
    assert [line["event"] for line in lines] == ["file.damaged"]
    assert len(list(tmp_path.glob("apps.sqlite.damaged-*"))) == 1
    assert rows(path) == {("hall", "armed"): True}


async def test_homebot_reports_the_trouble_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / STORE_FILE
    path.write_bytes(b"no database at all" * 100)
    path.chmod(0o600)
    async with Runtime(parse_config({}, "test"), with_door=False, index_file=tmp_path / "index.sqlite") as runtime:
        (problem,) = runtime.app_host.problems()
    assert problem.startswith(f"the file of the apps {path} was damaged")


async def test_a_file_that_breaks_or_goes_while_it_is_used_is_written_anew(tmp_path: Path) -> None:
    """All that it had is in memory."""
    path = tmp_path / "home" / STORE_FILE
    async with opened(path) as stores:
        stores.of("hall").update(one=1, two=2)
        await stores.flush()
        shutil.rmtree(path.parent)
        stores.of("hall")["three"] = 3
        await stores.flush()
        assert stores._kept is not None
        damage(stores._kept.file)
        stores.of("hall")["four"] = 4
        await stores.flush()
        await stores.flush()
    assert rows(path) == {("hall", name): number for number, name in enumerate(("one", "two", "three", "four"), 1)}
    assert len(list(path.parent.glob("apps.sqlite.damaged-*"))) == 1


async def test_a_file_that_cannot_be_read_is_not_written_over(tmp_path: Path) -> None:
    path = tmp_path / STORE_FILE
    async with opened(path) as stores:
        stores.of("hall")["armed"] = True
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA user_version = 99")
    before = path.read_bytes()
    with capture_logs() as lines:
        async with opened(path) as stores:
            stores.of("hall")["armed"] = False
            assert stores.of("hall")["armed"] is False
    assert path.read_bytes() == before
    (line,) = lines
    assert "written by a newer homebot" in line["message"]
    assert line["message"].endswith("until the next start the values of apps are in memory only")


async def test_what_cannot_be_written_now_is_written_later(tmp_path: Path) -> None:
    path = tmp_path / STORE_FILE
    async with opened(path) as stores:
        stores.of("hall")["armed"] = True
    with closing(sqlite3.connect(path)) as connection:
        fails = "SELECT abs(-9223372036854775808)"  # an error of the statement, as a full disk is one
        connection.execute(f"CREATE TRIGGER full BEFORE INSERT ON store BEGIN {fails}; END")
        connection.commit()
    with capture_logs() as lines:
        async with opened(path) as stores:
            stores.of("hall")["armed"] = False
            await stores.flush()
            assert stores._kept is not None
            stores._kept.file._opened().execute("DROP TRIGGER full")
    assert rows(path) == {("hall", "armed"): False}
    assert [line["event"] for line in lines] == ["file.not_written", "file.written_again"]


async def test_an_app_without_a_runtime_keeps_its_values_in_memory() -> None:
    class Hall(App):
        async def run(self) -> None:
            self.store["runs"] = self.store.get("runs", 0) + 1

    async with Node(Graph(), "hall") as node:
        hall = Hall(node, NoSettings())
        await hall.serve()
        await hall.serve()
        assert hall.store["runs"] == 2


class Counting(App):
    """Counts its starts, and crashes at the first."""

    async def run(self) -> None:
        self.store["starts"] = self.store.get("starts", 0) + 1
        if self.store["starts"] == 1:
            raise RuntimeError("ouch")
        COUNTED.set()
        await anyio.sleep_forever()


COUNTED = anyio.Event()


@pytest.mark.parametrize("is_kept", [True, False])
async def test_an_app_finds_its_values_after_a_crash_and_a_restart(tmp_path: Path, *, is_kept: bool) -> None:
    """Where nothing is remembered, they are in memory alone."""
    global COUNTED  # noqa: PLW0603 - an event belongs to a loop
    config = parse_config({"apps": {"counting": {"class": f"{__name__}:Counting"}}}, "test")
    index = tmp_path / "index.sqlite" if is_kept else None
    for _ in range(2):
        COUNTED = anyio.Event()
        with anyio.fail_after(PATIENCE):
            async with Runtime(config, with_door=False, index_file=index):
                await COUNTED.wait()
    assert (tmp_path / STORE_FILE).exists() is is_kept
    if is_kept:
        assert rows(tmp_path / STORE_FILE) == {("counting", "starts"): 3}


WRITER = """
import sys
from pathlib import Path
import anyio
from homebot.apps.stores import AppStores
from homebot.clock import LoopClock

async def main():
    stores = AppStores(Path(sys.argv[1]), LoopClock())
    await stores.read()
    store = stores.of("hall")
    number = store.get("first", 0)
    print("begins", flush=True)
    while True:
        number += 1
        store.update(first=number, text="x" * (number * 97 % 3000), second=number)
        await stores.flush()
        print(number, flush=True)

anyio.run(main)
"""


@pytest.mark.slow
async def test_a_kill_while_it_is_written_loses_nothing_that_was_written_before(tmp_path: Path) -> None:
    """The values of one moment stay together."""
    path, chance = tmp_path / STORE_FILE, random.Random(7)  # noqa: S311
    for _ in range(size(3, 8)):
        with subprocess.Popen([sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, text=True) as program:
            assert program.stdout is not None
            assert program.stdout.readline() == "begins\n"
            for _ in range(chance.randrange(1, 40)):
                said = int(program.stdout.readline())
            program.kill()
            rest = program.stdout.read().split("\n")[:-1]
            said = int(rest[-1]) if rest else said
        async with opened(path) as stores:
            store = stores.of("hall")
            assert store["first"] == store["second"] in {said, said + 1}
            assert len(store["text"]) == store["first"] * 97 % 3000
    assert not list(tmp_path.glob("*damaged*"))
