"""The page changes the configuration as its owner would, and a wrong step leaves it as it was."""

import json
import os
import tomllib
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import anyio
import pytest
from anyio import to_thread
from tests.discovery.announcements import announce, part_of
from tests.discovery.directory_house import directory
from tests.gateways.test_pairing import Bulbs
from tests.patience import PATIENCE

from homebot.cli.backup_archive import extract_archive
from homebot.config import load_config
from homebot.devices.app_messages import ChangeAppResponse, Reload, ReloadRequest
from homebot.features.page.backups import MAX_PART_BYTES
from homebot.features.page.page import offer_setup
from homebot.features.page.setup_messages import (
    BackupRequest,
    ChangeSetup,
    ChangeSetupRequest,
    ChangeSetupResponse,
    FindUnused,
    FindUnusedRequest,
    GetBackup,
    MakeToken,
    MakeTokenRequest,
    ReadTable,
    ReadTableRequest,
)
from homebot.gateways.pairing import PairingServices
from homebot.graph import Graph, Node
from homebot.messages.key_value import KeyValue
from homebot.runtime.saved_files import serve_copies
from homebot.support.installation import INSTALLATION_FILE

FILE = """\
[home]
name = "Villa"  # ours

[gateways.mqtt]
"""


class Wizard:
    """A page that sets homebot up; the reload reads the file, as that of homebot does."""

    def __init__(self, node: Node, file: Path) -> None:
        self.node = node
        self.file = file
        self.reloads: list[bool] = []
        self.is_over = anyio.Event()

    async def reload(self, request: ReloadRequest) -> ChangeAppResponse:
        self.reloads.append(request.allow_removal)
        try:
            await to_thread.run_sync(load_config, self.file)
        except Exception as exc:  # noqa: BLE001 - any mistake is told
            return ChangeAppResponse(success=False, message=str(exc))
        return ChangeAppResponse(success=True, message="reloaded")

    async def change(
        self,
        *table: str,
        values: dict[str, str] | None = None,
        secrets: dict[str, str] | None = None,
        remove: tuple[str, ...] = (),
        undo: bool = False,
        restart: bool = False,
    ) -> ChangeSetupResponse:
        given, kept = (
            tuple(KeyValue(key=key, value=value) for key, value in (pairs or {}).items()) for pairs in (values, secrets)
        )
        request = ChangeSetupRequest(table=table, values=given, secrets=kept, remove=remove, undo=undo, restart=restart)
        return await self.node.create_client(ChangeSetup, "/setup/change").call(request)

    async def read(self, *table: str) -> dict[str, Any]:
        answer = await self.node.create_client(ReadTable, "/setup/table").call(ReadTableRequest(table=table))
        assert answer.success
        return {pair.key: json.loads(pair.value) for pair in answer.values}


@asynccontextmanager
async def wizard(folder: Path) -> AsyncIterator[Wizard]:
    file = folder / "homebot.toml"
    file.write_text(FILE)
    graph = Graph()
    async with Node(graph, "page") as page, Node(graph, "homebot") as main, Node(graph, "screen") as screen:
        made = Wizard(screen, file)
        offer_setup(page, lambda: file if file.exists() else None, made.is_over.set)
        main.create_service(Reload, "/homebot/reload", made.reload)
        yield made


async def test_a_step_writes_its_lines_and_an_undo_takes_them_back(tmp_path: Path) -> None:
    async with wizard(tmp_path) as page:
        page.file.chmod(0o640)
        answer = await page.change("gateways", "hue", values={"host": '"10.0.0.2"', "act": "true"})
        assert (answer.success, answer.message) == (True, "reloaded")
        assert answer.lines == ("[gateways.hue]", "act = true", 'host = "10.0.0.2"')
        assert (await page.change("home", values={"name": '"Sun"'})).lines == ('name = "Sun"  # ours',)
        assert page.file.stat().st_mode & 0o777 == 0o640
        assert (await page.change(undo=True)).success
        assert page.file.read_text() == f'{FILE}\n[gateways.hue]\nact = true\nhost = "10.0.0.2"\n'
        page.file.write_text(FILE)
        assert "changed since" in (await page.change(undo=True)).message


@pytest.mark.parametrize(
    ("table", "values", "why"),
    [
        (("gateways", "mqtt"), {"url": "mqtt://x"}, "is no value of TOML"),
        (("gateways", "mqtt"), {"x": "[" * 3000}, "is no value of TOML"),
        (("gateways", "mqtt"), {"x": "[" * 70 + "]" * 70}, "is no value of TOML"),
        (("gateways", "mqtt"), {"x": "9" * 400}, "is no value of TOML"),
        (("gateways", "mqtt"), {"class": '"os:system"'}, "class loads a program or a file"),
        (("gateways",), {"spy": '{class = "os:system"}'}, "class loads a program or a file"),
        (("notify",), {"x": '[{deep = {class = "os:system"}}]'}, "class loads a program or a file"),
        (("gateways", "mqtt"), {"password_file": '"/etc/shadow"'}, "password_file loads a program or a file"),
        (("apps", "spy"), {"x": "1"}, "not among those that a page may change"),
        (("door",), {"token": '"x"'}, "not among those that a page may change"),
        ((), {"x": "1"}, "not among those"),
        (("home",), {"planet": '"Mars"'}, "the file is as it was"),
    ],
)
async def test_a_wrong_step_leaves_the_file_as_it_was(
    tmp_path: Path, table: tuple[str, ...], values: dict[str, str], why: str
) -> None:
    async with wizard(tmp_path) as page:
        answer = await page.change(*table, values=values)
        assert not answer.success
        assert why in answer.message
        assert page.file.read_text() == FILE


async def test_a_password_is_kept_in_a_file_of_its_own_until_the_step_is_taken_back(tmp_path: Path) -> None:
    async with wizard(tmp_path) as page:
        table, kept = ("gateways", "hass"), tmp_path / "gateway-hass.token"
        answer = await page.change(*table, values={"act": "true"}, secrets={"token": "hunter2"})
        assert {*answer.lines} == {"[gateways.hass]", 'token_file = "gateway-hass.token"', "act = true"}
        assert (kept.read_text(), kept.stat().st_mode & 0o777) == ("hunter2\n", 0o600)
        assert (await page.change(*table, values={"act": "false"}, secrets={"token": "hunter3"})).success
        assert kept.read_text() == "hunter3\n"
        await page.change(undo=True)
        assert kept.read_text() == "hunter2\n"
        (tmp_path / "gateway-other.token").write_text("a person's")
        wrong = (
            (("home",), "token"),
            (("gateways", "../x"), "token"),
            (table, "key"),
            (("gateways", "other"), "token"),
        )
        for names, key in wrong:
            assert not (await page.change(*names, secrets={key: "x"})).success
        files = {file.name for file in tmp_path.iterdir()}
        assert files == {"gateway-hass.token", "gateway-other.token", "homebot.toml"}


@pytest.mark.parametrize(
    ("table", "values", "why"),
    [
        (("mqtt",), {"url": '"mqtt://evil:1883"'}, "password_file of [gateways.mqtt] is for the address that is there"),
        (("mqtt",), {"url": '"mqtt://broker:1883"'}, "give it again with the other one"),  # it is sent in the clear
        (("ha",), {"url": '"https://evil"'}, "token_env of [gateways.ha] is for the address"),
        (("dir",), {"credentials": '[{host = "evil", password_env = "DIR"}]'}, "is for the address"),
        (("mdns", "drivers"), {"shelly": '{password_env = "PATH"}'}, "password_env of [drivers.shelly] names a secret"),
        ((), {"homeassistant": '{url = "https://evil", token_env = "HA"}'}, "is for the address that is there"),
    ],
)
async def test_a_kept_secret_is_not_sent_to_another_address(
    tmp_path: Path, table: tuple[str, ...], values: dict[str, str], why: str
) -> None:
    (tmp_path / "password").write_text("hunter2")
    text = """\
[gateways.mqtt]
url = "mqtts://broker"
password_file = "password"
[gateways.ha]
class = "homeassistant"
url = "https://ha:8123"
token_env = "HA"
[gateways.dir]
class = "thing_directory"
url = "https://dir"
credentials = [{ host = "dir", scheme = "basic", password_env = "DIR" }]
[gateways.mdns]
"""
    async with wizard(tmp_path) as page:
        page.file.write_text(text)
        answer = await page.change("gateways", *table, values=values)
        assert not answer.success
        assert why in answer.message
        assert page.file.read_text() == text


async def test_a_secret_that_is_given_with_an_address_is_for_that(tmp_path: Path) -> None:
    table = ("gateways", "mqtt")
    async with wizard(tmp_path) as page:
        first = {"url": '"mqtt://broker"'}
        assert (await page.change(*table, values=first, secrets={"password": "hunter2"})).success
        assert (await page.change(*table, values={"act": "true", "root": '"attic"'})).success
        assert (await page.change(*table, values={"url": '"mqtt://BROKER/"'})).success
        assert (await page.change(undo=True)).success
        other = {"url": '"mqtt://other"'}
        assert not (await page.change(*table, values=other)).success
        assert (await page.change(*table, values=other, secrets={"password": "hunter3"})).success
        assert not (await page.change(*table, values=first)).success
        assert (await page.change(undo=True)).success
        assert (tmp_path / "gateway-mqtt.password").read_text() == "hunter2\n"
        assert 'url = "mqtt://broker"' in page.file.read_text()


@pytest.mark.rooms("people")
async def test_people_are_added_changed_and_taken_out(tmp_path: Path) -> None:
    async with wizard(tmp_path) as page:
        answer = await page.change("people", "Anna", values={"ping": '"192.168.1.23"', "trackers": '["phone"]'})
        assert answer.lines == ("[people.Anna]", 'trackers = ["phone"]', 'ping = "192.168.1.23"')
        assert await page.read("people") == {"Anna": {"ping": "192.168.1.23", "trackers": ["phone"]}}
        assert (await page.change("people", remove=("Anna",))).success
        assert await page.read("people") == {}
        assert (await page.change(undo=True)).success
        assert "Anna" in await page.read("people")


async def test_an_address_is_shown_without_its_password_and_kept_by_what_is_shown(tmp_path: Path) -> None:
    urls = ["tgram://123456:secret/777", "json://10.0.0.1/x", "tgram://123456:other/777"]
    async with wizard(tmp_path) as page:
        answer = await page.change("notify", values={"urls": json.dumps(urls)})
        assert answer.lines == ("[notify]", 'urls = ["tgram://…77", "json://…/x", "tgram://…77 (2)"]')
        seen = (await page.read("notify"))["urls"]
        assert seen == ["tgram://…77", "json://…/x", "tgram://…77 (2)"]
        kept = json.dumps(["json://…/x", "tgram://…77 (2)", "ntfy://new"], ensure_ascii=False)
        assert (await page.change("notify", values={"urls": kept})).success
        assert tomllib.loads(page.file.read_text())["notify"]["urls"] == [urls[1], urls[2], "ntfy://new"]
        gone = json.dumps(["tgram://…99"], ensure_ascii=False)
        assert "not in the file any more" in (await page.change("notify", values={"urls": gone})).message


@pytest.mark.parametrize("table", ["gateways", "door", "apps"])
async def test_a_table_with_secrets_or_rights_is_not_read(tmp_path: Path, table: str) -> None:
    async with wizard(tmp_path) as page:
        answer = await page.node.create_client(ReadTable, "/setup/table").call(ReadTableRequest(table=(table,)))
        assert (answer.success, answer.values) == (False, ())


async def test_a_backup_comes_in_parts_and_is_that_of_the_command_line(tmp_path: Path) -> None:
    (data := tmp_path / "home" / "broker").mkdir(parents=True)
    (data / INSTALLATION_FILE).write_bytes(os.urandom(9 * MAX_PART_BYTES // 4))
    async with wizard(tmp_path) as page, Node(page.node.graph, "copies") as node:
        serve_copies(node, data)
        client = page.node.create_client(GetBackup, "/setup/backup")
        answer = await client.call(BackupRequest())
        name, found = answer.name, answer.data
        assert len(found) == MAX_PART_BYTES
        while len(found) < answer.size:
            answer = await client.call(BackupRequest(offset=len(found)))
            found += answer.data
        assert name.startswith("Villa-")
        await to_thread.run_sync((archive := tmp_path / name).write_bytes, found)
        manifest = await to_thread.run_sync(extract_archive, archive, tmp_path)
        assert [*manifest.files] == [f"data/{INSTALLATION_FILE}", "config/homebot.toml"]
        assert [file.name for file in data.iterdir()] == [INSTALLATION_FILE]
        assert "begin with 0" in (await client.call(BackupRequest(offset=4000))).message


async def test_homebot_begins_again_when_the_page_asks_for_it(tmp_path: Path) -> None:
    """A new gateway waits for a start, which needed a shell."""
    async with wizard(tmp_path) as page:
        assert (await page.change(restart=True)).success
        with anyio.fail_after(PATIENCE):
            await page.is_over.wait()
        assert page.file.read_text() == FILE


async def test_a_run_without_a_file_says_so(tmp_path: Path) -> None:
    async with wizard(tmp_path) as page:
        page.file.unlink()
        assert "without a file" in (await page.change("home", values={"name": '"Sun"'})).message


@pytest.mark.parametrize(
    ("scope", "rights", "is_made"),
    [
        (("act: all",), ("read", "act: light in hall"), True),
        (("act: light",), ("read", "act: light"), True),
        (("act: light",), ("read", "act: all"), False),
        (("act: all",), ("raw",), False),
    ],
)
async def test_a_token_has_no_more_rights_than_who_makes_it(
    tmp_path: Path, scope: tuple[str, ...], rights: tuple[str, ...], is_made: object
) -> None:
    async with wizard(tmp_path) as page:
        request = MakeTokenRequest(name="wall", grants=rights, issuer="client:owner", scope=scope)
        answer = await page.node.create_client(MakeToken, "/setup/token").call(request)
        assert answer.success is is_made
        tables = tomllib.loads(page.file.read_text())
        if is_made:
            assert tables["door"]["tokens"]["wall"] == {"token_file": "wall.token", "scope": [*rights]}
            assert (tmp_path / "wall.token").read_text().strip() == answer.token
        else:
            assert (answer.token, page.file.read_text()) == ("", FILE)


@pytest.mark.virtual_time
@pytest.mark.parametrize(
    ("open_port", "servers"),
    [
        (0, []),
        pytest.param(
            8123,
            [("homeassistant", (), "", "http://127.0.0.1:8123")],
            marks=pytest.mark.rooms("homeassistant"),
        ),
    ],
)
async def test_what_no_gateway_uses_is_found_with_the_next_step(open_port: int, servers: list[object]) -> None:
    facts = {"needs_gateway": "hue", "next_step": "press its button"}
    async with directory() as house, Node(house.asker.graph, "page") as page:
        PairingServices(Bulbs(), Node(house.asker.graph, "bulbs", namespace="/gateway"))

        async def listens(port: int) -> bool:
            return port == open_port

        offer_setup(page, lambda: None, listens=listens)
        await house.hears(
            announce("l", part_of("light", "on_off", id="p"), ids=("id:l",), name="Lamp", at=1.0),
            announce("b", part_of("x_unknown", id="p"), ids=("id:b",), name="Bridge", facts=facts, at=1.0),
        )
        answer = await house.asker.create_client(FindUnused, "/setup/found").call(FindUnusedRequest())
        assert [(row.gateway, row.names, row.next, row.url) for row in answer.unused] == [
            ("hue", ("Bridge",), "press its button", ""),
            *servers,
        ]
        waiting = [(one.gateway, one.unpaired.name) for one in answer.unpaired]
        assert waiting == [("bulbs", "Bulb one"), ("bulbs", "Bulb two")]
        assert (answer.file, answer.can_restart) == ("", False)


@pytest.mark.virtual_time
@pytest.mark.rooms("people")
async def test_people_are_no_gateway_of_the_page() -> None:
    async with directory() as house, Node(house.asker.graph, "page") as page:
        Node(house.asker.graph, "people", namespace="/gateway")
        offer_setup(page, lambda: None)
        answer = await house.asker.create_client(FindUnused, "/setup/found").call(FindUnusedRequest())
        assert (*answer.gateways,) == ("mqtt",)
