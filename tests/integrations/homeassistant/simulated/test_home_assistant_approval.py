"""Devices of a Home Assistant that can hurt or annoy: rights, approval, quiet hours and leases, as for any gateway."""

import asyncio
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import anyio
import pytest
from tests.integrations.homeassistant.simulated.server import Fields, ListedEntity, SimulatedHomeAssistant
from tests.loopback import alone_on_loopback
from tests.patience import PATIENCE

from homebot.cli.main import main
from homebot.config import parse_config
from homebot.devices import Devices
from homebot.devices.always_ask import CHANGED
from homebot.devices.handles import AlarmPanel, Closure, DoorLock, Handle, Siren, WaterValve
from homebot.devices.outcomes import Refused
from homebot.graph import Node
from homebot.runtime import Runtime

pytestmark = pytest.mark.slow


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of entities: its attributes and states, and the command that opens it.

    Attributes:
        handle: The handle of its device.
        after: Its state after each service.
        command: The command, as capability and value.
        word: Its word for ``homebot do``.
        quiet: Its words in quiet hours.
        kept: The word for its state before, for a lease.
        sent: The service call as the owner is shown it.
    """

    handle: type[Handle]
    entity_id: str
    attributes: Fields
    before: str
    after: Mapping[str, str]
    command: tuple[str, str | bool]
    word: str
    quiet: str
    kept: str
    sent: str


KINDS: Mapping[str, Kind] = {
    "lock": Kind(
        DoorLock,
        "lock.front_door",
        {"supported_features": 0},
        "locked",
        {"unlock": "unlocked", "lock": "locked"},
        ("lock", "unlocked"),
        "unlock",
        "unlock door lock",
        "lock",
        'lock=unlocked: lock.unlock {"entity_id":"lock.front_door"}',
    ),
    "alarm panel": Kind(
        AlarmPanel,
        "alarm_control_panel.house",
        {"supported_features": 3, "code_format": None, "code_arm_required": False},
        "armed_away",
        {"alarm_disarm": "disarmed", "alarm_arm_away": "armed_away"},
        ("alarm", "disarmed"),
        "disarmed",
        "disarm x_alarm_panel",
        "armed_away",
        'alarm=disarmed: alarm_control_panel.alarm_disarm {"entity_id":"alarm_control_panel.house"}',
    ),
    "garage door": Kind(
        Closure,
        "cover.garage",
        {"device_class": "garage", "supported_features": 3},
        "closed",
        {"open_cover": "open", "close_cover": "closed"},
        ("movement", "open"),
        "open",
        "open closure",
        "close",
        'movement=open: cover.open_cover {"entity_id":"cover.garage"}',
    ),
    "water valve": Kind(
        WaterValve,
        "valve.main",
        {"device_class": "water", "supported_features": 3},
        "closed",
        {"open_valve": "open", "close_valve": "closed"},
        ("valve", "open"),
        "open",
        "open water valve",
        "close",
        'valve=open: valve.open_valve {"entity_id":"valve.main"}',
    ),
    "siren": Kind(
        Siren,
        "siren.hall",
        {"supported_features": 3},
        "off",
        {"turn_on": "on", "turn_off": "off"},
        ("on_off", True),
        "on",
        "use siren",
        "off",
        'on_off=on: siren.turn_on {"entity_id":"siren.hall"}',
    ),
}
CAN_HURT = [name for name in KINDS if name != "siren"]


class KnownEntity(ListedEntity):
    """Such an entity, which obeys at once."""

    def __init__(self, kind: Kind, server: SimulatedHomeAssistant) -> None:
        super().__init__()
        self.kind = kind
        self.entity_id = kind.entity_id
        self.shown = kind.before
        self.attributes = {**kind.attributes, "friendly_name": "Thing"}
        self.calls: list[str] = []
        self._server = server

    def call(self, service: str, data: Fields) -> bool:
        del data
        self.calls.append(service)
        self._server.show(self, self.kind.after[service], {})
        return True

    def rename(self, entity_id: str) -> None:
        """Give it another id, as a person does."""
        self._server.remove(self)
        self.entity_id = entity_id
        self._server.reach(self)

    def entry(self) -> Fields:
        return {"id": "1", "unique_id": "1", "device_id": "thing", "labels": []}

    def device_entry(self) -> Fields:
        return {"id": "thing", "name": "Thing", "area_id": "hall", "identifiers": [["x", "1"]], "connections": []}


class House:
    """A house with one such entity, and nothing simulated that homebot knows of.

    Attributes:
        entity: The entity.
    """

    def __init__(self, runtime: Runtime, node: Node, entity: KnownEntity, files: dict[str, Path]) -> None:
        self.entity = entity
        self._door = "" if runtime.rosbridge is None else f"127.0.0.1:{runtime.rosbridge.port}"
        self._devices = Devices(node)
        self._files = files

    async def handle(self) -> Handle:
        with anyio.fail_after(PATIENCE):
            while not (found := await self._devices.find(self.entity.kind.handle)):  # noqa: ASYNC110 - it comes late
                await anyio.sleep(0.05)
        return found[0]

    async def run(self, capsys: pytest.CaptureFixture[str], *words: str, token: str = "keeper") -> str:
        """Run a command in a terminal; return what it prints."""
        login = ["--token-file", str(self._files[token])] if token else []
        capsys.readouterr()
        await asyncio.to_thread(main, [*words, "--door", self._door, *login])
        out, err = capsys.readouterr()
        return out + err

    async def do(self, capsys: pytest.CaptureFixture[str], *, with_token: bool) -> str:
        """Open it, as a person does in a terminal."""
        return await self.run(capsys, "do", "Thing", self.entity.kind.word, token="panel" if with_token else "")


@asynccontextmanager
async def house(tmp_path: Path, kind: str, *, trusts_apps: bool = False, **control: object) -> AsyncIterator[House]:
    home = SimulatedHomeAssistant()
    entity = KnownEntity(KINDS[kind], home)
    tokens = {"home": home.token, "panel": "only for the thing", "keeper": "who approves"}
    files = {name: tmp_path / name for name in tokens}
    for name, file in files.items():
        file.touch(mode=0o600)
        file.write_text(tokens[name])
    scopes = {"panel": ["read", 'act: id="thing"'], "keeper": ["read", "manage"]}
    named = {name: {"token_file": str(files[name]), "scope": scope} for name, scope in scopes.items()}
    async with alone_on_loopback(), anyio.create_task_group() as tasks:
        await tasks.start(home.serve)
        home.reach(entity, "hall")
        tables = {
            "gateways": {"homeassistant": {"url": home.url, "token_file": str(files["home"])}},
            "door": {"port": 0, "tokens": named},
            "control": control,
            "discovery": {"persist": False},
        }
        async with (
            Runtime(parse_config(tables, "test"), trusts_apps=trusts_apps) as runtime,
            Node(runtime.graph, "app") as node,
        ):
            found = House(runtime, node, entity, files)
            await found.handle()
            yield found
        tasks.cancel_scope.cancel()


@pytest.mark.parametrize("kind", CAN_HURT)
async def test_nothing_is_sent_before_the_owner_has_approved_what_would_be(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    async with house(tmp_path, kind) as thing:
        assert "refused (rights): client:local may not command thing" in await thing.do(capsys, with_token=False)
        refused = await thing.do(capsys, with_token=True)
        assert "refused (approval)" in refused
        assert "homebot approve Thing" in refused
        shown = await thing.run(capsys, "approve", "Thing", "--show")
        assert "waits for approval; its commands:" in shown
        assert KINDS[kind].sent in shown
        assert thing.entity.calls == []
        assert KINDS[kind].sent in await thing.run(capsys, "approve", "Thing")
        assert "refused (rights)" in await thing.do(capsys, with_token=False)
        assert thing.entity.calls == []
        assert "confirmed" in await thing.do(capsys, with_token=True)
        assert len(thing.entity.calls) == 1


@pytest.mark.parametrize("kind", CAN_HURT)
async def test_an_approval_ends_when_the_entity_is_another(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It may be another door behind the same name."""
    async with house(tmp_path, kind) as thing:
        await thing.run(capsys, "approve", "Thing")
        thing.entity.rename(f"{thing.entity.entity_id}_2")
        with anyio.fail_after(PATIENCE):
            while CHANGED not in (shown := await thing.run(capsys, "show", "Thing")):  # noqa: ASYNC110 - in steps
                await anyio.sleep(0.05)
        assert "the payloads of its commands changed" in shown
        assert "refused (approval)" in await thing.do(capsys, with_token=True)
        assert thing.entity.calls == []
        await thing.run(capsys, "approve", "Thing")
        assert "confirmed" in await thing.do(capsys, with_token=True)
        assert len(thing.entity.calls) == 1


@pytest.mark.parametrize("kind", KINDS)
async def test_an_app_obeys_quiet_hours(kind: str, tmp_path: Path) -> None:
    quiet = [{"start": "00:00", "end": "23:59", "commands": [KINDS[kind].quiet]}]
    async with house(tmp_path, kind, trusts_apps=True, quiet_hours=quiet) as thing:
        outcome = await (await thing.handle()).command(*KINDS[kind].command)
        assert isinstance(outcome, Refused)
        assert outcome.policy == "quiet_hours"
        assert thing.entity.calls == []


@pytest.mark.parametrize("kind", KINDS)
async def test_what_a_holder_keeps_as_it_is_nobody_changes(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    async with house(tmp_path, kind, trusts_apps=True) as thing:
        async with (await thing.handle()).hold(KINDS[kind].kept, by="judge"):
            thing.entity.calls.clear()
            assert "refused (lease): held" in await thing.do(capsys, with_token=True)
            assert thing.entity.calls == []
        assert "confirmed" in await thing.do(capsys, with_token=True)
