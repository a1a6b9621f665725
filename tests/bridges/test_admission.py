"""Who may connect; guessing tokens becomes slow, and stays bearable for whoever knows the right one."""

import anyio
import pytest
from pydantic import SecretStr

from homebot.bridges.admission import TokenCheck, name_of_token, refusal, token_of
from homebot.bridges.rosbridge import DoorSettings
from homebot.clock import LoopClock

pytestmark = pytest.mark.virtual_time

LOCAL = DoorSettings()
NAMED = DoorSettings(host="hub.lan", token=SecretStr("t"))
EVERYWHERE = DoorSettings(host="0.0.0.0", token=SecretStr("t"))  # noqa: S104  # the case under test
PANEL = DoorSettings(allowed_origins=("https://panel.example.org", "null"))
PROXY = DoorSettings(allowed_origins=("https://house.example", "null"), token=SecretStr("t"))


@pytest.mark.parametrize(
    ("settings", "host", "origin"),
    [
        (LOCAL, "127.0.0.1:9090", ""),
        (LOCAL, "localhost", ""),
        (LOCAL, "LOCALHOST:1234", ""),
        (LOCAL, "[::1]:9090", ""),
        (LOCAL, "127.8.9.1", ""),
        (NAMED, "hub.lan:9090", ""),
        (EVERYWHERE, "192.168.1.5:9090", ""),
        (EVERYWHERE, "[fd00::1]:9090", ""),
        (PROXY, "house.example", ""),
        (LOCAL, "127.0.0.1:9090", "http://localhost:3000"),
        (LOCAL, "127.0.0.1:9090", "http://127.0.0.1"),
        (LOCAL, "127.0.0.1:9090", "http://[::1]:8080"),
        (PANEL, "127.0.0.1:9090", "https://panel.example.org"),
        (PANEL, "127.0.0.1:9090", "null"),
        (NAMED, "hub.lan:9090", "http://hub.lan"),
    ],
)
def test_a_client_that_calls_us_by_our_name_and_a_page_of_ours_are_let_in(
    settings: DoorSettings, host: str, origin: str
) -> None:
    assert refusal(settings, [host], [origin] if origin else []) is None


@pytest.mark.parametrize(
    ("settings", "host"),
    [
        (LOCAL, "evil.example:9090"),
        (LOCAL, "127.0.0.1.evil.example"),
        (LOCAL, "192.168.1.5:9090"),
        (LOCAL, ""),
        (LOCAL, "[::1"),
        (LOCAL, "127.0.0.1?\udcb5"),
        (LOCAL, "127.0.0.1/x"),
        (LOCAL, "localhost@127.0.0.1"),
        (NAMED, "other.lan"),
        (EVERYWHERE, "evil.example"),
        (PANEL, "panel.example.org"),
        (PROXY, "evil.example"),
        (PROXY, "null"),
        (PROXY, ""),
    ],
)
def test_a_foreign_name_is_refused(settings: DoorSettings, host: str) -> None:
    """DNS rebinding: the page's own name points to us."""
    problem = refusal(settings, [host], [])
    assert problem is not None
    assert "does not accept the host name" in problem


@pytest.mark.parametrize(
    "origin", ["https://evil.example", "http://localhost.evil.example", "null", "file://", "http://[", "", "nonsense"]
)
def test_a_foreign_page_is_refused(origin: str) -> None:
    problem = refusal(LOCAL, ["127.0.0.1:9090"], [origin])
    assert problem is not None
    assert "are not allowed" in problem


def test_doubled_headers_are_refused() -> None:
    assert refusal(LOCAL, ["127.0.0.1", "evil.example"], []) is not None
    assert refusal(LOCAL, [], []) is not None
    assert refusal(LOCAL, ["127.0.0.1"], ["http://localhost", "https://evil.example"]) is not None


def test_the_token_comes_in_the_header_or_in_the_query() -> None:
    assert token_of("/", ["Bearer abc"]) == "abc"
    assert token_of("/?token=a%20b", []) == "a b"
    assert token_of("/?token=query", ["bearer header"]) == "header"
    assert token_of("/?token=query", ["Basic xyz"]) == "query"
    assert token_of("/", []) == ""
    assert token_of("//[?token=x", []) == "x"


def test_only_the_right_token_opens() -> None:
    tokens = {"owner": SecretStr("t"), "robot": SecretStr("u")}
    assert name_of_token(tokens, "t") == "owner"
    assert name_of_token(tokens, "u") == "robot"
    assert name_of_token(tokens, "T") == ""
    assert name_of_token(tokens, "") == ""
    assert name_of_token(tokens, "\ud800é") == ""


LONG, SHORT = "0123456789abcdef", "1234"


def checked() -> TokenCheck:
    return TokenCheck({"robot": SecretStr(LONG), "page": SecretStr(SHORT)}, LoopClock())


async def waited(check: TokenCheck, address: str, token: str = "wrong") -> float:
    """The seconds that a token from an address waits."""
    began = anyio.current_time()
    assert await check.check(address, token) is not None
    return anyio.current_time() - began


async def guessed(*addresses: str) -> TokenCheck:
    """A check that was shown thirty wrong tokens from some addresses by turns."""
    check = checked()
    for number in range(30):
        await check.check(addresses[number % len(addresses)], "wrong")
    return check


async def test_the_first_wrong_tokens_cost_nothing_and_then_each_waits_longer_up_to_a_second() -> None:
    check = checked()
    waits = [await waited(check, "10.0.0.5") for _ in range(12)]
    assert waits[:6] == pytest.approx([0.0] * 5 + [0.1])
    assert waits[5:] == sorted(waits[5:])
    assert waits[-1] == pytest.approx(1.0)
    assert check.wrong == 12


async def test_the_right_token_waits_as_long_as_a_wrong_one_and_is_not_counted() -> None:
    check = await guessed("10.0.0.5")
    assert await waited(check, "10.0.0.5", SHORT) == pytest.approx(1.0)
    assert check.wrong == 30
    assert await waited(check, "10.0.0.6") == 0.0


async def test_only_four_tokens_of_an_address_wait_at_a_time() -> None:
    check = await guessed("10.0.0.5")
    async with anyio.create_task_group() as tasks:
        for _ in range(4):
            tasks.start_soon(check.check, "10.0.0.5", "wrong")
        await anyio.sleep(0.5)
        assert await check.check("10.0.0.5", LONG) is None
    assert await check.check("10.0.0.5", LONG) == "robot"


async def test_wrong_tokens_are_forgotten_in_time() -> None:
    check = await guessed("10.0.0.5")
    assert check.problems() == ("wrong tokens were received from 10.0.0.5",)
    await anyio.sleep(155.0)
    assert await waited(check, "10.0.0.5") == 0.0
    await anyio.sleep(145.0)
    assert check.problems() == ()
    assert not check._attempts


async def test_addresses_of_one_network_are_one_address() -> None:
    check = await guessed(*(f"2001:db8::{number:x}" for number in range(30)))
    assert await waited(check, "2001:db8::ffff") == pytest.approx(1.0)
    assert await waited(check, "2001:db8:0:1::1") == 0.0
    check = await guessed("::ffff:10.0.0.5")
    assert await waited(check, "10.0.0.5") == pytest.approx(1.0)


async def test_it_remembers_a_thousand_addresses_and_programs_at_most() -> None:
    check = checked()
    for number in range(1001):
        for token in ("wrong", LONG):
            await check.check(f"10.0.{number // 256}.{number % 256}", token)
    assert len(check._attempts) == len(check._proven) == 1000
    assert ("10.0.0.0", "robot") not in check._proven


async def test_a_long_token_that_was_right_does_not_wait_and_a_short_one_tells_no_guesser_anything() -> None:
    check = checked()
    for token in (LONG, SHORT):
        await check.check("10.0.0.5", token)
    for number in range(60):
        await check.check(f"10.0.0.{5 + number % 2}", "wrong")
    assert await waited(check, "10.0.0.5", LONG) == 0.0
    assert await waited(check, "10.0.0.5", SHORT) == pytest.approx(1.0)
    assert await waited(check, "10.0.0.6", LONG) == pytest.approx(1.0)
