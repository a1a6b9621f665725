"""Devices of a house as aiohomekit, the controller of Home Assistant, finds them behind the bridge, over loopback."""

import hashlib
import os
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, Final

import anyio
import pytest
from tests.features.homekit_bridge.house import LAMP, LOCK, BridgedHouse, bridged_house
from tests.patience import PATIENCE, until

pytest.importorskip("pyhap")
pytest.importorskip("aiohomekit")

from aiohomekit.characteristic_cache import CharacteristicCacheMemory
from aiohomekit.controller.ip import IpController, IpDiscovery
from aiohomekit.controller.ip.connection import HomeKitConnection
from aiohomekit.crypto.hkdf import hkdf_derive
from aiohomekit.exceptions import AuthenticationError, UnavailableError
from aiohomekit.model.categories import Categories
from aiohomekit.model.feature_flags import FeatureFlags
from aiohomekit.model.status_flags import StatusFlags
from aiohomekit.protocol.tlv import TLV
from aiohomekit.zeroconf import HomeKitService
from cryptography.hazmat.primitives.ciphers.aead import ChaCha20Poly1305

pytestmark = pytest.mark.slow

ON, BRIGHTNESS, NAME, LOCK_TARGET = (f"{kind:0>8}-0000-1000-8000-0026BB765291" for kind in ("25", "8", "23", "1E"))
NO_RESPONSE: Final = -70402
LOOPBACK: Final = "127.0.0.1"
HOUSE: Final = {"hall_lamp": LAMP, "old_lamp": LAMP, "front_door": LOCK, "back_door": LOCK}


class Controller:
    """A controller that is paired."""

    def __init__(self, pairing: Any) -> None:
        self.pairing = pairing
        self.events: dict[tuple[int, int], object] = {}
        pairing.dispatcher_connect(self._on_event)

    async def accessories(self) -> dict[str, dict[str, tuple[int, int]]]:
        """Return the ids of characteristics by the names of their accessories, and their types."""
        found: dict[str, dict[str, tuple[int, int]]] = {}
        for accessory in await self.pairing.list_accessories_and_characteristics():
            rows = [row for service in accessory["services"] for row in service["characteristics"]]
            name = next(row["value"] for row in rows if row["type"] == NAME)
            found[name] = {row["type"]: (accessory["aid"], row["iid"]) for row in reversed(rows)}
        return found

    async def write(self, place: tuple[int, int], value: object) -> int:
        return int((await self.pairing.put_characteristics([(*place, value)])).get(place, {}).get("status", 0))

    async def read(self, place: tuple[int, int]) -> Mapping[str, object]:
        return dict((await self.pairing.get_characteristics([place]))[place])

    async def has(self, name: str) -> bool:
        return name in await self.accessories()

    async def is_away(self, place: tuple[int, int]) -> bool:
        return (await self.read(place)).get("status") == NO_RESPONSE

    def _on_event(self, values: Mapping[tuple[int, int], Mapping[str, object]]) -> None:
        self.events |= {place: row.get("value") for place, row in values.items()}


def service(device: str, port: int) -> HomeKitService:
    return HomeKitService(
        name="Villa",
        id=device,
        model="homebot",
        feature_flags=FeatureFlags(0),
        status_flags=StatusFlags.UNPAIRED,
        config_num=1,
        state_num=1,
        category=Categories.BRIDGE,
        protocol_version="1.1",
        type="_hap._tcp.local.",
        address=LOOPBACK,
        addresses=[LOOPBACK],
        port=port,
    )


def finds_nothing() -> Any:
    kind: Any = IpController
    return kind(CharacteristicCacheMemory(), None)


def discovered(device: str, port: int) -> Any:
    return IpDiscovery(finds_nothing(), service(device, port))


async def pair(house: BridgedHouse, code: str = "", number: int = 0) -> dict[str, object]:
    """Pair, and return the keys; HAP-python leaves out a leading 0 of one key in 256."""
    bridge = (await house.pairing()).bridges[number]
    for is_last in (False, False, True):
        discovery = discovered(bridge.id, bridge.port)
        try:
            finish = await discovery.async_start_pairing(bridge.id)
            pairing = await finish(code or bridge.code)
            await pairing.close()
            return dict(pairing.pairing_data)
        except AuthenticationError:
            if code or is_last:
                raise
        finally:
            await discovery.close()
        await anyio.sleep(0.2)
    raise AssertionError


@asynccontextmanager
async def controller(house: BridgedHouse, data: Mapping[str, object]) -> AsyncIterator[Controller]:
    port = (await house.pairing()).bridges[0].port
    place = {"AccessoryIP": LOOPBACK, "AccessoryIPs": [LOOPBACK], "AccessoryPort": port, "Connection": "IP"}
    pairing = finds_nothing().load_pairing(str(data["AccessoryPairingID"]), {**data, **place})
    try:
        yield Controller(pairing)
    finally:
        await pairing.close()


async def eventually(ask: Callable[[], Awaitable[object]]) -> None:
    """Wait until the answer is true: nothing tells a controller of it."""
    with anyio.fail_after(PATIENCE):
        while not await ask():  # noqa: ASYNC110
            await anyio.sleep(0.05)


def lit(house: BridgedHouse) -> Callable[[], object]:
    return lambda: [command.value.plain() for command in house.gateway.commands if command.capability == "on_off"]


@pytest.mark.newest("homekit")
async def test_a_lamp_is_paired_switched_and_followed_and_tells_when_it_does_not_obey(tmp_path: Path) -> None:
    export = ["light", "lock", 'name="Front door"']
    async with bridged_house(None, HOUSE, export=export) as house:
        house.gateway.stubborn = frozenset({"old_lamp"})
        with pytest.raises(AuthenticationError):
            await pair(house, "111-22-333")
        await anyio.sleep(0.2)
        data = await pair(house)
        await anyio.sleep(0.2)
        with pytest.raises(UnavailableError):
            await pair(house, "111-22-333")
        async with controller(house, data) as apple:
            rooms = await apple.accessories()
            assert rooms.keys() == {"Villa", "Hall lamp", "Old lamp", "Front door"}  # the other lock is not named
            lamp, old = rooms["Hall lamp"], rooms["Old lamp"]
            assert await apple.read(lamp[ON]) == {"value": False}
            await apple.pairing.subscribe([lamp[ON], lamp[BRIGHTNESS]])
            assert await apple.write(lamp[ON], True) == 0
            assert await apple.read(lamp[ON]) == {"value": True}
            assert await apple.write(lamp[BRIGHTNESS], 40) == 0
            assert await apple.read(lamp[BRIGHTNESS]) == {"value": 40}
            await house.report("hall_lamp", on_off=False)  # by hand
            await until(lambda: apple.events.get(lamp[ON]) is False)

            assert await apple.write(old[ON], True) == NO_RESPONSE
            assert await apple.read(old[ON]) == {"value": False}
            house.gateway.devices.report_reachable("hall_lamp", reachable=False)
            await eventually(lambda: apple.is_away(lamp[ON]))

            assert (await apple.read(rooms["Front door"][LOCK_TARGET]))["status"] == NO_RESPONSE  # it is unknown
            assert await apple.write(rooms["Front door"][LOCK_TARGET], 1) == 0
            assert [command.value.plain() for command in house.gateway.commands][-1] == "locked"
            answer = await house.pairing()
            assert "by its name alone" in answer.left_out[0].value
            assert (answer.bridges[0].code, answer.bridges[0].controllers) == ("", 1)


async def test_a_pairing_and_the_numbers_of_accessories_survive_restarts_and_new_names(tmp_path: Path) -> None:
    file = tmp_path / "homekit.pairings.json"
    async with bridged_house(file, {"hall_lamp": LAMP}, export=["light"]) as house:
        data = await pair(house)
        async with controller(house, data) as apple:
            before = (await apple.accessories())["Hall lamp"]
            await house.put("hall_lamp", LAMP, "Lantern")
            await eventually(lambda: apple.has("Lantern"))
            assert (await apple.accessories())["Lantern"] == before
            await house.put("attic_lamp", LAMP, on_off=True)
            await eventually(lambda: apple.has("Attic lamp"))
    assert file.stat().st_mode & 0o777 == 0o600
    async with bridged_house(file, {"attic_lamp": LAMP, "hall_lamp": LAMP}, export=["light"]) as house:
        async with controller(house, data) as apple:
            assert (await apple.accessories())["Hall lamp"] == before
            assert await apple.write(before[ON], True) == 0
            assert lit(house)() == [True]
        assert (await house.unpair()).controllers == 1
        assert (await house.pairing()).bridges[0].code
        await pair(house)


async def test_nobody_pairs_without_the_code_by_a_public_key_of_zero() -> None:
    """With it the session's key would be known to all (RFC 5054, 2.5.4)."""
    async with bridged_house(None, {"hall_lamp": LAMP}, export=["light"]) as house:
        bridge = (await house.pairing()).bridges[0]
        discovery = discovered(bridge.id, bridge.port)
        connection: HomeKitConnection = discovery.connection
        await connection.ensure_connection()

        async def post(*rows: tuple[int, Any]) -> dict[int, bytes]:
            expected = [
                TLV.kTLVType_State,
                TLV.kTLVType_Error,
                TLV.kTLVType_Salt,
                TLV.kTLVType_PublicKey,
                TLV.kTLVType_Proof,
                TLV.kTLVType_EncryptedData,
            ]
            return dict(await connection.post_tlv("/pair-setup", body=list(rows), expected=expected))

        first = await post((TLV.kTLVType_State, TLV.M1), (TLV.kTLVType_Method, TLV.PairSetup))
        assert TLV.kTLVType_Salt in first
        second = await post(
            (TLV.kTLVType_State, TLV.M3), (TLV.kTLVType_PublicKey, bytes(384)), (TLV.kTLVType_Proof, bytes(64))
        )
        assert second[TLV.kTLVType_Error] == TLV.kTLVError_Authentication
        for secret in (b"", bytes(384)):
            key = hkdf_derive(hashlib.sha512(secret).digest(), b"Pair-Setup-Encrypt-Salt", b"Pair-Setup-Encrypt-Info")
            sealed = ChaCha20Poly1305(key).encrypt(b"\0\0\0\0PS-Msg05", os.urandom(40), b"")
            third = await post((TLV.kTLVType_State, TLV.M5), (TLV.kTLVType_EncryptedData, sealed))
            assert third[TLV.kTLVType_Error] == TLV.kTLVError_Authentication
        await discovery.close()
        assert (await house.pairing()).bridges[0].controllers == 0
