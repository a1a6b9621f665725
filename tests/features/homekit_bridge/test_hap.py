"""What a bridge for HomeKit answers to requests that break the rules, over loopback."""

import logging

import anyio
import pytest
from tests.features.homekit_bridge.house import LAMP, bridged_house

pytest.importorskip("pyhap")

STATE, ERROR, KEY, PROOF, SEALED = 6, 7, 3, 4, 5
UNKNOWN = 1


def tlv(*rows: tuple[int, bytes]) -> bytes:
    return b"".join(
        bytes([tag, len(value[at : at + 255])]) + value[at : at + 255]
        for tag, value in rows
        for at in range(0, len(value), 255)
    )


async def post(port: int, path: str, body: bytes) -> tuple[int, bytes]:
    async with await anyio.connect_tcp("127.0.0.1", port) as stream:
        await stream.send(f"POST {path} HTTP/1.1\r\nHost: a\r\nContent-Length: {len(body)}\r\n\r\n".encode() + body)
        head, _, answer = (await stream.receive()).partition(b"\r\n\r\n")
        return int(head.split()[1]), answer


M3 = tlv((STATE, b"\3"), (KEY, b"\1" * 384), (PROOF, bytes(64)))
M5 = tlv((STATE, b"\5"), (SEALED, bytes(40)))


@pytest.mark.parametrize(
    ("body", "state"), [(M3, 4), (M5, 6), (tlv((STATE, b"\2")), 3), (tlv((STATE, b"\xff")), 0)], ids=str
)
async def test_a_step_of_a_pairing_that_has_not_begun_is_refused(
    body: bytes, state: int, caplog: pytest.LogCaptureFixture
) -> None:
    async with bridged_house(None, {"hall_lamp": LAMP}, export=["light"]) as house:
        port = (await house.pairing()).bridges[0].port
        assert await post(port, "/pair-setup", body) == (400, tlv((STATE, bytes([state])), (ERROR, bytes([UNKNOWN]))))
    assert [one for one in caplog.records if one.levelno >= logging.WARNING] == []


@pytest.mark.parametrize(
    ("path", "body", "status"),
    [
        ("/pair-setup", b"", 400),
        ("/pair-setup", b"\6\1", 400),
        ("/pairings", tlv((0, b"\5")), 400),
        ("//[", b"", 400),
        ("/nothing", b"", 404),
        ("/accessories", b"", 404),
        ("/resource", b"{}", 401),
        ("/pair-verify", M3, 200),  # nobody is paired, says the library
    ],
)
async def test_a_request_that_breaks_the_rules_is_refused_and_no_failure(
    path: str, body: bytes, status: int, caplog: pytest.LogCaptureFixture
) -> None:
    async with bridged_house(None, {"hall_lamp": LAMP}, export=["light"]) as house:
        assert (await post((await house.pairing()).bridges[0].port, path, body))[0] == status
    assert [one for one in caplog.records if one.levelno >= logging.WARNING] == []
