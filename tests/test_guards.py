"""The guards that every test stands under: homebot must not block the event loop, and is tested as it is."""

import ast
import gc
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from blockbuster import BlockingError
from tests.conftest import panics_in
from tests.source_trees import source_trees

import homebot
from homebot.cli.main import gc_paused

BLOCKING = "import time; time.sleep(0)"


async def test_code_of_homebot_that_blocks_the_loop_is_caught() -> None:
    with pytest.raises(BlockingError, match=r"time\.sleep"):
        exec(compile(BLOCKING, homebot.__file__, "exec"))  # noqa: S102  # as if it stood in the package


async def test_code_of_a_test_may_block() -> None:
    time.sleep(0)  # noqa: ASYNC251  # what is under test


def test_without_a_loop_anything_may_block() -> None:
    exec(compile(BLOCKING, homebot.__file__, "exec"))  # noqa: S102  # as if it stood in the package


def test_a_panic_of_a_library_is_found_in_the_output_of_a_test() -> None:
    """They were printed by the dozen, and the tests passed."""
    place = "/root/zenoh/src/net/routing/dispatcher/queries.rs:557:29"
    text = f"[info] started\n\nthread '<unnamed>' (7) panicked at {place}:\ncalled `Result::unwrap()`: PoisonError\n"
    assert panics_in(text) == [f"thread '<unnamed>' (7) panicked at {place}:"]
    assert panics_in(text.replace("queries", "resource"))
    assert panics_in(text.replace("queries", "resource").replace("<unnamed>", "net-0")) == []
    assert panics_in("the gateway panicked at nothing\n") == []


_PATCHES = {"setattr", "delattr", "setitem", "delitem", "patch", "object"}


def test_no_test_patches_homebot() -> None:
    """One that does tests something else: what a test has to change is an argument."""
    files = sorted(Path(__file__).parent.rglob("*.py"))
    gc.collect()  # what is garbage now may have something to warn of
    with gc_paused():
        found = [f"{file}:{line}" for file in files for line in _patched(file.read_text(encoding="utf-8"))]
    assert found == []


@pytest.mark.parametrize(
    "patch",
    [
        'monkeypatch.setattr("homebot.clock.NOW", 5)',
        'monkeypatch.setattr(clock, "NOW", 5)',
        'monkeypatch.setitem(clock.TABLE, "now", 5)',
        'mock.patch.object(clock.Clock, "now")',
        'setattr(clock, "NOW", 5)',
        "clock.NOW = 5",
    ],
)
def test_a_patch_of_homebot_is_found(patch: str) -> None:
    assert list(_patched(f"from homebot import clock\n{patch}")) == [2]


def _patched(text: str) -> Iterator[int]:
    """Yield the lines of a test that patch something of homebot."""
    nodes = list(ast.walk(ast.parse(text)))
    found = [one for one in nodes if isinstance(one, ast.Import | ast.ImportFrom)]
    ours = {
        (alias.asname or alias.name).partition(".")[0]
        for one in found
        for alias in one.names
        if ((one.module or "") if isinstance(one, ast.ImportFrom) else alias.name).partition(".")[0] == "homebot"
    }
    for node in nodes:
        if isinstance(node, ast.Call) and node.args and _name(node.func) in _PATCHES and _is_ours(node.args[0], ours):
            yield node.lineno
        if isinstance(node, ast.Assign) and any(
            isinstance(one, ast.Attribute) and _is_ours(one.value, ours) for one in node.targets
        ):
            yield node.lineno


def _name(function: ast.expr) -> str:
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def _is_ours(target: ast.expr, ours: set[str]) -> bool:
    if isinstance(target, ast.Constant):
        return isinstance(target.value, str) and target.value.startswith("homebot.")
    while isinstance(target, ast.Attribute):
        target = target.value
    return isinstance(target, ast.Name) and target.id in ours


def bound_twice(tree: ast.Module) -> list[str]:
    """Return the names that the statements of a module bind by assignment more than once."""
    targets = [
        target
        for statement in tree.body
        if isinstance(statement, ast.Assign | ast.AnnAssign)
        for target in (statement.targets if isinstance(statement, ast.Assign) else [statement.target])
    ]
    flat = [part for target in targets for part in (target.elts if isinstance(target, ast.Tuple) else [target])]
    names = [part.id for part in flat if isinstance(part, ast.Name)]
    return sorted({name for name in names if names.count(name) > 1})


def test_no_constant_of_a_module_is_bound_twice() -> None:
    """The first one is lost without a word, as two limits of the broker's cache were that bore one name."""
    assert bound_twice(ast.parse("A, B = 1, 2\nB: int = 3\nA.x = B['y'] = 4")) == ["B"]
    assert {path: names for path, tree in source_trees().items() if (names := bound_twice(tree))} == {}
