"""Where homebot touches the inside of a library: the whole list, and the versions of a library for which it was read.

Inside is what a library may change without telling: a private name, or a method or an attribute of its classes that a
class of ours takes over. A public way is taken where there is one.
"""

import ast
import importlib
import inspect
import pkgutil
import re
import sys
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import packages_distributions
from itertools import chain
from pathlib import Path
from typing import Final, NamedTuple

import pytest
from packaging.requirements import Requirement

import homebot

ROOT: Final = Path(__file__).parent.parent
SOURCE: Final = Path(homebot.__file__).parent


class Inside(NamedTuple):
    """What is touched of a library.

    Attributes:
        names: By file.
        why: Why there is no public way, or who says that it is one.
        read: The newest version for which it was read, without its last number: pyproject.toml takes none beyond. Empty
            if the names are there for subclasses.
    """

    names: Mapping[str, str]
    why: str
    read: str = ""


INSIDES: Final[Mapping[str, Inside]] = {
    "HAP-python": Inside(
        {
            "features/homekit_bridge/hap.py": "async_persist async_start connection_made data_received dispatch"
            " finish_pair get_characteristics get_iid_for_obj handle_pairing handle_set_characteristics handler"
            " http_server loop parsed_url prepare register_failed_pairing_attempt request_body response server"
            " setup_srp_verifier srp_verifier write",
        },
        "public names, which 5.2 changed: a bridge with limits is no use that it foresees",
        read="5.2",
    ),
    "aiohomekit": Inside(
        {"integrations/homekit/gateway/aiohomekit_port.py": "_connect_once"},
        "last_connector_error is forgotten when the next attempt begins",
        read="4.0",
    ),
    "habluetooth": Inside(
        {"gateways/ble_proxies/hub.py": "_async_on_advertisement _discover_service_info _loop _is_retry_client"},
        "the first two are for scanners and managers of others; async_setup, which sets the loop, replaces bleak's"
        " classes; the last is what bleak-retry-connector passes",
        read="7.2",
    ),
    "zeroconf": Inside(
        {
            "gateways/mdns/zeroconf_network.py": "DNSIncoming RecordManager async_update_records"
            " async_updates_from_response record_manager query_scheduler"
        },
        "listeners are not told who sent a response, of which the type is exported by chance, and nothing else ends the"
        " queries after a flood",
        read="0.154",
    ),
    "aiomqtt": Inside({"mqtt/client/aiomqtt_adapter.py": "_client"}, "its paho client has no public name", read="2.5"),
    "aiocoap": Inside(
        {
            "gateways/coap/aiocoap_client.py": "token_interface message_interface datagram_msg_received",
        },
        "it limits no requests",
        read="0.4",
    ),
    "nfcpy": Inside(
        {"gateways/nfc/nfcpy_reader.py": "exchange"},
        "public method; its tags call it, and have no limit of their own",
        read="1.0",
    ),
    "aioesphomeapi": Inside(
        {"integrations/esphome/driver/connection.py": "subscribe_bluetooth_le_raw_advertisements"}, "documented method"
    ),
    "bleak-esphome": Inside(
        {"integrations/esphome/driver/bluetooth_proxy.py": "disconnect_callbacks"}, "a field of its public answer"
    ),
    "websockets": Inside(
        {
            "bridges/rosbridge/connection.py": "connection_lost connection_made data_received pause_writing"
            " process_event resume_writing recv_messages",
            "integrations/homeassistant/gateway/link.py": "max_size max_message_size",
        },
        "asyncio's methods, and its own event; its limits have no setter",
    ),
    "mcp": Inside({"bridges/home_api/agent_server.py": "call_tool"}, "documented method"),
    "PyYAML": Inside(
        {"cli/yaml_loader.py": "compose_node construct_mapping yaml_constructors yaml_implicit_resolvers"},
        "its way to make a loader",
    ),
    "pytest": Inside({"testing/house_fixtures.py": "_fixtureinfo"}, "as pytest does; each test of an app runs it"),
    "anyio": Inside({"runtime/supervisor.py": "started"}, "the one method of TaskStatus"),
    "Python": Inside(
        {
            "apps/created_tasks.py": "_getframe _log_traceback",
            "apps/schedule.py": "_getframe",
            "bridges/rosbridge/connection.py": "max_size",
            "cli/arguments.py": "_negative_number_matcher _SubParsersAction",
            "cli/parser.py": "_SubParsersAction _actions _check_value _option_string_actions",
            "cli/script.py": "_getframe",
            "support/production_loop.py": "_current_frames",
            "support/virtual_time.py": "_ready _callback",
            "testing/loop_guard.py": "_selector",
        },
        "argparse, asyncio and sys; CI runs each version of Python",
    ),
}

NO_LIBRARY: Final = frozenset({"homebot", "pydantic", "typing_extensions", *sys.stdlib_module_names})
OF_PYTHON: Final = frozenset({"_abc_impl", "_is_protocol"})

_DISTRIBUTIONS: Final = packages_distributions()


@cache
def _text(module: str) -> str:
    """Return the source of a module, that of a compiled one too."""
    place = Path(str(sys.modules[module].__file__))
    file = place.with_name(f"{place.name.partition('.')[0]}.py")
    return file.read_text() if file.exists() else ""


def _is_of_library(module: str) -> bool:
    return module.partition(".")[0] not in NO_LIBRARY


def _takes_over(base: type, name: str) -> bool:
    """Return whether a class that has *name*, or whose objects have it, takes over something of *base* by it."""
    if name in vars(base):
        return not getattr(vars(base)[name], "__isabstractmethod__", False)
    return re.search(rf"\bself\.{name}\b(?! *\()", _text(base.__module__)) is not None


def _taken_over(kind: type, tree: ast.ClassDef) -> Iterator[str]:
    bases = [base for base in kind.__mro__[1:] if _is_of_library(base.__module__)]
    if not bases:
        return
    own = [one for one in ast.walk(tree) if isinstance(one, ast.Attribute) and ast.unparse(one.value) in OWN_OBJECT]
    names = {one.attr for one in own if isinstance(one.ctx, ast.Store) or one.attr.startswith("_")}
    for name in names | vars(kind).keys() - OF_PYTHON:
        if not name.startswith("__") and any(_takes_over(base, name) for base in bases):
            yield name


OWN_OBJECT: Final = frozenset({"self", "super()"})


def _found_in(tree: ast.Module, lines: list[str], module: object) -> Iterator[str]:
    defined = {one.name for one in ast.walk(tree) if isinstance(one, ast.FunctionDef | ast.AsyncFunctionDef)}
    for node in ast.walk(tree):
        match node:
            case ast.ImportFrom(module=str(name)) if _is_of_library(name) and "._" in name:
                yield from (alias.name for alias in node.names)
            case ast.Attribute(attr=attr) if (
                "noqa: SLF001" in lines[node.lineno - 1]  # which ruff wants for each
                and attr.startswith("_")
                and ast.unparse(node.value) not in OWN_OBJECT
                and attr not in defined
            ):
                yield attr
            case ast.ClassDef(name=name) if inspect.isclass(kind := getattr(module, name, None)):
                yield from _taken_over(kind, node)


def test_every_place_that_touches_the_inside_of_a_library_is_listed_and_is_still_there() -> None:
    listed: dict[str, set[str]] = {}
    for file, names in chain.from_iterable(one.names.items() for one in INSIDES.values()):
        listed.setdefault(file, set()).update(names.split())
    found: dict[str, set[str]] = {}
    for module in pkgutil.walk_packages(homebot.__path__, "homebot."):
        if module.name.endswith("__main__"):
            continue
        loaded = importlib.import_module(module.name)
        place = Path(str(loaded.__file__))
        inside = set(_found_in(ast.parse(text := place.read_text()), text.splitlines(), loaded))
        if inside:
            found[str(place.relative_to(SOURCE))] = inside
    assert {file: inside for file, inside in found.items() if not inside <= listed.get(file, set())} == {}
    by_hand = {(file, name) for file, inside in listed.items() for name in inside - found.get(file, set())}
    assert [one for one in by_hand if not re.search(rf"\b{one[1]}\b", (SOURCE / one[0]).read_text())] == []


def _requirements() -> Iterator[Requirement]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for line in chain(project["dependencies"], *project["optional-dependencies"].values()):
        yield Requirement(line)


@pytest.mark.parametrize("library", [name for name, inside in INSIDES.items() if inside.read])
def test_a_library_is_installed_in_no_version_beyond_those_for_which_its_inside_was_read(library: str) -> None:
    *major, minor = map(int, INSIDES[library].read.split("."))
    beyond = ".".join(map(str, (*major, minor + 1, 0)))
    needed = [one.specifier for one in _requirements() if one.name == library]
    assert needed
    for one in needed:
        assert one.contains(f"{INSIDES[library].read}.99")
        assert not one.contains(beyond), f"{library} {beyond}: read it, then let {one} take it"


@pytest.mark.parametrize("library", [name for name, inside in INSIDES.items() if inside.read])
def test_the_lowest_version_of_a_library_whose_inside_is_touched_is_tested(library: str) -> None:
    """``make test-lowest`` installs it."""
    lowest = dict(re.findall(r"^(\S+)==(\S+)$", (ROOT / "constraints-lowest.txt").read_text(), re.MULTILINE))[library]
    for one in _requirements():
        if one.name == library:
            bound = next(part.version for part in one.specifier if part.operator == ">=")
            assert f"{lowest}.".startswith(f"{bound}."), library
