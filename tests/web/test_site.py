"""The files of the page: complete, loaded from nowhere else, and asked for again only when they changed."""

import gzip
import json
import os
import re
import sys
from http import HTTPStatus
from pathlib import Path
from shutil import copytree, ignore_patterns

import anyio
import pytest
from anyio import to_thread
from tests.patience import PATIENCE

import homebot.web
from homebot.config import parse_config
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.health import GetHealth
from homebot.devices.names import RUNTIME_HEALTH
from homebot.graph import Node
from homebot.runtime import Runtime
from homebot.web.site import answer

SCRIPTS = [f"/{path.name}" for path in (Path(homebot.web.__file__).parent / "page").glob("*.js")]
EVERY_FILE = ["/", "/page.css", "/icon.svg", "/icon.png", "/licences.txt", "/vocabulary.json", *sorted(SCRIPTS)]
MANIFEST = "/manifest.webmanifest"


def body(path: str) -> str:
    found = answer(path, "")
    assert found is not None
    return found[2].decode()


@pytest.mark.parametrize("path", [*EVERY_FILE, MANIFEST])
def test_a_file_has_its_type_and_length_and_a_policy_that_lets_no_foreign_script_in(path: str) -> None:
    found = answer(f"{path}?x=1", "")
    assert found is not None
    status, headers, content = found
    assert status == HTTPStatus.OK
    assert headers["Content-Length"] == str(len(content))
    assert headers["Content-Security-Policy"].startswith("default-src 'none'; script-src 'self'; ")
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Content-Security-Policy"].endswith("; require-trusted-types-for 'script'; trusted-types worker")


@pytest.mark.parametrize("path", [*EVERY_FILE, MANIFEST])
def test_a_text_is_compressed_for_a_browser_that_takes_it(path: str) -> None:
    """A page of 200 kB took a second at a tablet at the edge of the network."""
    plain, packed, unasked = (answer(path, "", one) for one in ("", "gzip, deflate, br", "br, gzip;q=0"))
    assert plain is not None
    assert packed is not None
    assert unasked == plain
    assert "Accept-Encoding" in packed[1]["Vary"]
    if path == "/icon.png":
        assert packed == plain
        return
    assert packed[1]["Content-Encoding"] == "gzip"
    assert packed[1]["ETag"] != plain[1]["ETag"]
    assert gzip.decompress(packed[2]) == plain[2]
    again = answer(path, packed[1]["ETag"], "gzip")
    assert again is not None
    assert again[0] == HTTPStatus.NOT_MODIFIED


def test_what_a_screen_loads_is_small() -> None:
    """A cheap tablet draws the first view within a second."""
    size = {path: len(found[2]) for path in EVERY_FILE if (found := answer(path, "", "gzip"))}
    first = ["/page.js"]
    for path in first:  # what is imported at once grows the list
        named = re.findall(r'(?:from|import) ?"\./([\w-]+\.js)"', body(path))
        first += [f"/{name}" for name in named if f"/{name}" not in first]
    assert all(f'modulepreload" href="{path[1:]}"' in body("/") for path in first[1:])
    linked = next(path for path in SCRIPTS if path.startswith("/soon-"))  # of a link to a room
    languages = [path for path in SCRIPTS if re.match(r"/[a-z]{2}(_late)?-", path)]
    assert len(languages) == 10
    by_language = [
        sum(size[path] for path in languages if path.startswith(f"/{own}")) for own in ("de", "es", "fr", "it", "nl")
    ]
    early = max(size[path] for path in languages if "_late" not in path)
    assert size["/page.css"] <= 8_000
    assert early + sum(size[path] for path in [*first, linked, "/", "/page.css", "/vocabulary.json"]) <= 60_000
    assert sum(size[path] for path in SCRIPTS) - sum(sorted(by_language)[:-1]) <= 110_000


def test_a_file_that_the_browser_has_is_not_sent_again() -> None:
    found = answer("/page.js", "")
    assert found is not None
    again = answer("/page.js", found[1]["ETag"])
    assert again is not None
    assert (again[0], again[2]) == (HTTPStatus.NOT_MODIFIED, b"")


async def test_a_worker_keeps_the_files_of_the_build_that_homebot_says_it_has() -> None:
    """A page whose build differs from that of homebot reloads."""
    first = (await to_thread.run_sync(body, "/worker.js")).partition("\n")[0]
    named = re.fullmatch(r'const BUILD = "(\w{16})", FILES = (\[.*\]);', first)
    assert named
    assert {"/" if name == "index.html" else f"/{name}" for name in json.loads(named[2])} == {
        *EVERY_FILE,
        MANIFEST,
    } - {"/worker.js"}
    async with Runtime(parse_config({}, "test")) as runtime, Node(runtime.graph, "asker") as asker:
        health = await asker.create_client(GetHealth, RUNTIME_HEALTH).call(GetHealth.Request())
    assert health.build == named[1]


async def test_a_page_stays_whole_when_an_update_replaces_its_files(tmp_path: Path) -> None:
    """Each file that was gone crashed the answer, and the page stayed empty until homebot was started again."""
    package = Path(homebot.web.__file__).parents[1]
    await to_thread.run_sync(lambda: copytree(package, tmp_path / "homebot", ignore=ignore_patterns("__pycache__")))
    script = f"""
import shutil
from homebot.web.site import answer
answer("/", "")
shutil.rmtree({str(tmp_path / "homebot/web/page")!r})
print(all(answer(path, "") for path in {EVERY_FILE}))"""
    command = [sys.executable, "-c", script]
    done = await anyio.run_process(command, env={**os.environ, "PYTHONPATH": str(tmp_path)})
    assert done.stdout.decode().strip() == "True"


@pytest.mark.parametrize("path", ["/index.html", "/robots.txt", "/../secrets", "/source/page.js", "//etc/passwd"])
def test_there_are_no_other_files(path: str) -> None:
    assert answer(path, "") is None


def test_the_manifest_names_files_of_the_page() -> None:
    found = json.loads(body(MANIFEST))
    assert found["start_url"] == "./?installed"  # else it may be an address with a token
    assert {f"/{one['src']}" for one in found["icons"]} <= {*EVERY_FILE}


def test_the_page_names_no_other_server() -> None:
    """A phone in a house without internet shows it."""
    for path in ("/", "/page.css"):
        assert not re.search(r"(?:https?:)?//[a-z]", body(path))
    assert set(re.findall(r"https?://[\w./]+", "".join(map(body, SCRIPTS)))) <= {
        "http://www.w3.org/1998/Math/MathML",
        "http://www.w3.org/1999/xhtml",
        "http://www.w3.org/2000/svg",
    }


def test_the_vocabulary_has_the_units_of_the_capabilities_and_the_failures() -> None:
    found = json.loads(body("/vocabulary.json"))
    assert found["units"]["level"] == "%"
    assert found["units"] == {name: one.unit for name, one in CAPABILITIES.items() if one.unit}
    assert "no_answer" in found["failures"]
    assert not {"confirmed", "superseded"} & set(found["failures"])


async def test_a_running_homebot_serves_the_page_at_the_port_of_its_door() -> None:
    tables = {"door": {"port": 0, "token": "hunter2"}}
    async with Runtime(parse_config(tables, "test")) as runtime:
        assert runtime.rosbridge is not None
        async with await anyio.connect_tcp("127.0.0.1", runtime.rosbridge.port) as stream:
            await stream.send(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")
            with anyio.fail_after(PATIENCE):
                head = (await stream.receive()).decode()
    assert head.startswith("HTTP/1.1 200 OK\r\n")
    assert "hunter2" not in head
