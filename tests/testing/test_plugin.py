"""The plug-in in other people's test runs: every way to run async tests, and no configuration at all."""

import subprocess
import sys

import pytest
from tests.testing.conftest import ANYIO_ON_ASYNCIO, Tried

pytest_plugins = ["pytester"]

USE = """
import asyncio, pytest

{mark}async def test_a_client_is_heard(mqtt_broker, mqtt_broker_session):
    for broker in (mqtt_broker, mqtt_broker_session):
        reader, writer = await asyncio.open_connection(broker.host, broker.port)
        writer.write(bytes.fromhex("100d00044d5154540402003c000161") + bytes.fromhex("300500017436{payload}"))
        assert await reader.readexactly(4) == bytes.fromhex("20020000")
        assert (await broker.expect("t", "6{text}", timeout={timeout})).client_id == "a"
        await broker.settle()
        assert set(broker.clients) == {{"a"}}
        writer.close()
        await writer.wait_closed()

def test_a_test_without_a_loop_has_a_broker_too(mqtt_broker_thread):
    mqtt_broker_thread.publish("t", {{"a": 1}}, retain=True)
    mqtt_broker_thread.settle(0.01)
"""


@pytest.mark.parametrize(
    ("mark", "options", "conftest"),
    [
        ("@pytest.mark.asyncio\n", "-p no:anyio", ""),
        ("", "--asyncio-mode=auto", ""),
        ("@pytest.mark.anyio\n", "-p no:asyncio", ANYIO_ON_ASYNCIO),
        ("", "-p no:asyncio -p no:anyio", ""),
        ("", "", ""),
    ],
    ids=["pytest-asyncio, strict", "pytest-asyncio, auto", "anyio", "neither", "pytest-asyncio leaves it alone"],
)
def test_it_works_with_any_plugin_for_async_tests(tried: Tried, mark: str, options: str, conftest: str) -> None:
    tried(USE.format(mark=mark, payload="37", text="7", timeout=5), options, conftest=conftest, passed=2)


def test_a_failed_test_shows_the_packets_of_each_broker_that_had_any(tried: Tried) -> None:
    result = tried(
        USE.format(mark="@pytest.mark.asyncio\n", payload="38", text="9", timeout=0.5),
        passed=1,
        failed=1,
        lines=[
            "E *no client published '69' on t within 0.5 s",
            "E *received with another payload:",
            "E *t '68' (QoS 0, from a)",
            "*MQTT packets of mqtt_broker*",
            "*→  CONNECT 'a' MQTT 3.1.1, clean start, keep-alive 60 s",
            "* a  *→  PUBLISH t '68' QoS 0",
            "* a  *←  CONNACK success",
        ],
    )
    assert result.stdout.str().count("MQTT packets of") == 1


def test_those_who_do_not_use_it_import_nothing_for_it() -> None:
    program = (
        "import pytest, sys; before = set(sys.modules); import homebot.testing.plugin\n"
        "print(*sorted(set(sys.modules) - before))"
    )
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.split()
    assert loaded == ["homebot", "homebot.testing", "homebot.testing.plugin"]


BREACH = """
import asyncio, pytest

async def break_it(broker):
    reader, writer = await asyncio.open_connection(broker.host, broker.port)
    writer.write(bytes.fromhex("100d00044d5154540402003c000161") + bytes.fromhex("d000"))
    await reader.read()
    writer.close()
    await writer.wait_closed()

@pytest.mark.asyncio
async def test_a_fresh_broker(mqtt_broker):
    await break_it(mqtt_broker)

@pytest.mark.asyncio
async def test_a_shared_broker(mqtt_broker_session):
    await break_it(mqtt_broker_session)

@pytest.mark.asyncio
async def test_the_next_on_the_shared_broker(mqtt_broker_session):
    pass

@pytest.mark.asyncio
@pytest.mark.mqtt_broker(allow_protocol_errors=True)
async def test_it_is_allowed(mqtt_broker, mqtt_broker_session):
    await break_it(mqtt_broker)
    await break_it(mqtt_broker_session)

@pytest.mark.asyncio
async def test_after_what_was_allowed(mqtt_broker_session):
    pass
"""


def test_a_test_whose_client_breaks_the_protocol_fails_unless_it_is_allowed(tried: Tried) -> None:
    tried(
        BREACH,
        passed=5,
        errors=2,
        lines=[
            "*ERROR at teardown of test_a_fresh_broker*",
            "mqtt_broker: client 'a' broke the protocol: a client must not send Pingresp (0x82, protocol error)",
            "to allow it, mark the test with @pytest.mark.mqtt_broker(allow_protocol_errors=True)",
            "*MQTT packets of mqtt_broker*",
            "*ERROR at teardown of test_a_shared_broker*",
            "mqtt_broker_session: client 'a' broke the protocol: *",
        ],
    )


def test_a_mark_that_cannot_be_used_says_why(tried: Tried) -> None:
    tests = """
import pytest

@pytest.mark.mqtt_broker(keepalive=5)
def test_a_typo(mqtt_broker): pass

@pytest.mark.mqtt_broker(5)
def test_a_bare_value(mqtt_broker): pass

@pytest.mark.mqtt_broker(tls=1)
def test_a_wrong_type(mqtt_broker_thread): pass
"""
    lines = [
        "@pytest.mark.mqtt_broker: there is no argument 'keepalive'; did you mean keep_alive?",
        "@pytest.mark.mqtt_broker: name the arguments, as in keep_alive=5",
        "@pytest.mark.mqtt_broker: tls is True or False, not 1",
    ]
    tried(tests, errors=3, lines=lines)


def test_the_mark_nearest_to_a_test_counts_most(tried: Tried) -> None:
    tests = """
import pytest

pytestmark = pytest.mark.mqtt_broker(keep_alive=5, tls=True)

@pytest.mark.mqtt_broker(tls=False)
def test_both(mqtt_broker):
    assert (mqtt_broker.settings.keep_alive, mqtt_broker.settings.tls) == (5, False)
"""
    tried(tests, passed=1)
