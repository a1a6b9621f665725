"""Devices are paired and unpaired through a gateway, and no code is kept or shown."""

import stat
from collections.abc import Iterator
from pathlib import Path

import anyio
import pytest

from homebot.devices.names import ONLY_OBSERVES, PairingNames
from homebot.errors import LinkError, RefusedError, TypeMismatchError, UsageError
from homebot.gateways.pairing import (
    ListUnpaired,
    Pair,
    PairingFile,
    PairingServices,
    PairRequest,
    PairResponse,
    Unpair,
    UnpairedDevice,
    UnpairedRequest,
    UnpairRequest,
)
from homebot.graph import Graph, Node
from homebot.messages.json import message_from_json

CODE = "031-45-154"
NAMES = PairingNames("bulbs")

pytestmark = pytest.mark.virtual_time


class Bulbs:
    """A gateway of bulbs, each with the same code; the bulb ``far`` has no power, and ``slow`` takes a second."""

    acts = True
    observes_because = ONLY_OBSERVES

    def __init__(self) -> None:
        self.paired: set[str] = set()

    async def pair(self, key: str, code: str) -> str:
        if key == "far":
            raise LinkError("the bulb far does not answer")
        if key == "slow":
            await anyio.sleep(1)
        if code != CODE:
            raise RefusedError(f"pairing {key}", "the code is wrong")
        self.paired.add(key)
        return f"Bulb {key}"

    async def unpair(self, key: str) -> str:
        self.paired.remove(key)
        return f"Bulb {key}"

    def unpaired(self) -> Iterator[UnpairedDevice]:
        for key in ("one", "two"):
            if key not in self.paired:
                yield UnpairedDevice(device=key, name=f"Bulb {key}", takes_code=True, within_s=60.0)


class Home:
    """The gateway on a graph, and a client."""

    def __init__(self) -> None:
        graph = Graph()
        self.bulbs = Bulbs()
        PairingServices(self.bulbs, Node(graph, "bulbs", namespace="/gateway"))
        self._client = Node(graph, "client")

    async def pair(self, device: str, code: str = "") -> PairResponse:
        return await self._client.create_client(Pair, NAMES.pair).call(PairRequest(device=device, code=code))

    async def unpair(self, device: str) -> PairResponse:
        return await self._client.create_client(Unpair, NAMES.unpair).call(UnpairRequest(device=device))

    async def waiting(self) -> list[str]:
        answer = await self._client.create_client(ListUnpaired, NAMES.unpaired).call(UnpairedRequest())
        return [one.name for one in answer.devices]


async def test_a_device_waits_until_it_is_paired() -> None:
    home = Home()
    assert await home.waiting() == ["Bulb one", "Bulb two"]
    await home.pair("one", CODE)
    assert await home.waiting() == ["Bulb two"]


async def test_a_device_is_paired_by_its_code_and_unpaired() -> None:
    home = Home()
    assert await home.pair("one", CODE) == PairResponse(success=True, key="one", name="Bulb one")
    assert home.bulbs.paired == {"one"}
    assert await home.unpair("one") == PairResponse(success=True, key="one", name="Bulb one")
    assert home.bulbs.paired == set()


@pytest.mark.parametrize(("device", "problem"), [("one", "refused"), ("far", "unreachable")])
async def test_a_failure_says_whether_the_same_may_work_later(device: str, problem: str) -> None:
    answer = await Home().pair(device, "000-00-000")
    assert (answer.success, answer.problem) == (False, problem)
    assert answer.message


async def test_a_gateway_that_only_observes_pairs_nothing() -> None:
    home = Home()
    home.bulbs.acts = False
    answer = await home.pair("one", CODE)
    assert (answer.problem, home.bulbs.paired) == ("refused", set())
    assert ONLY_OBSERVES in answer.message


async def test_one_device_is_paired_at_a_time() -> None:
    home = Home()
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(home.pair, "slow", CODE)
        await anyio.wait_all_tasks_blocked()
        assert (await home.pair("one", CODE)).problem == "busy"
    assert home.bulbs.paired == {"slow"}
    assert (await home.pair("one", CODE)).success


def test_no_text_about_a_request_shows_its_code() -> None:
    request = PairRequest(device="one", code=CODE)
    assert CODE not in f"{request} {request!r}"
    with pytest.raises(TypeMismatchError) as caught:
        message_from_json(PairRequest, {"device": "one", "code": CODE * 40})
    assert CODE not in str(caught.value)


def test_pairings_are_kept_in_a_file_for_its_owner_alone(tmp_path: Path) -> None:
    path = tmp_path / "state" / "bulbs.json"
    assert PairingFile(path).load() == {}
    PairingFile(path).save({"one": {"key": "secret"}})
    PairingFile(path).save({"two": {"key": "secret"}})
    assert PairingFile(path).load() == {"two": {"key": "secret"}}
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert [one.name for one in path.parent.iterdir()] == ["bulbs.json"]


def test_without_a_file_nothing_is_kept() -> None:
    PairingFile(None).save({"one": {}})
    assert PairingFile(None).load() == {}


@pytest.mark.parametrize(("content", "mode"), [('{"secret', 0o600), ('["secret"]', 0o600), ('{"secret": {}}', 0o666)])
def test_a_file_that_cannot_be_trusted_is_refused_without_showing_it(tmp_path: Path, content: str, mode: int) -> None:
    path = tmp_path / "bulbs.json"
    path.write_text(content)
    path.chmod(mode)
    with pytest.raises(UsageError, match=r"bulbs\.json") as caught:
        PairingFile(path).load()
    assert "secret" not in str(caught.value)


def test_a_file_that_cannot_be_written_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="cannot be kept"):
        PairingFile(tmp_path / "file" / "bulbs.json").save({})
