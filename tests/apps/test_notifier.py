"""Notifications of apps to people, by MQTT and by apprise."""

import asyncio
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer

import anyio
import pytest
from structlog.testing import capture_logs
from structlog.typing import EventDict

from homebot import App
from homebot.apps.notifier import DROPPED, NOT_SENT, SENT
from homebot.config import Config, parse_config
from homebot.errors import ConfigError
from homebot.runtime import Runtime
from homebot.runtime.plan import make_plan
from homebot.testing import TestHouse, VirtualHouse
from homebot.testing.house import house_config

SECRET = "s3cretw0rd"


def washing(runtime: Runtime) -> App:
    return runtime.app_host.running["waiting"]


@pytest.fixture
def lines() -> Iterator[list[EventDict]]:
    """The log lines."""
    with capture_logs() as found:
        yield found


class Waiting(App):
    async def run(self) -> None:
        """Wait for a day."""
        await anyio.sleep(86_400)


WAITING = f"{__name__}:Waiting"
"""Of an app that runs while the test lasts."""


def events(lines: list[EventDict], event: str) -> list[str]:
    return [str(one["message"]) for one in lines if one["event"] == event]


@pytest.mark.house(WAITING, config={"notify": {}, "home": {"zone": "Europe/Berlin"}})
async def test_a_notification_is_published_with_title_app_and_time(house: VirtualHouse) -> None:
    assert await washing(house.runtime).notify("Washing is done", title="Cellar")
    assert json.loads(await house.hears("homebot/notifications")) == {
        "title": "Cellar",
        "message": "Washing is done",
        "app": "waiting",
        "time": "2026-01-01T01:00:00+01:00",
        "urgency": "normal",
        "kind": "",
    }
    (sent,) = house.notifications
    assert (sent.message, sent.title, sent.app) == ("Washing is done", "Cellar", "waiting")


@pytest.mark.house(WAITING)
async def test_without_the_table_notifications_are_logged_and_that_is_said_once(
    lines: list[EventDict], house: VirtualHouse
) -> None:
    app = washing(house.runtime)
    assert not await app.notify("first")
    assert not await app.notify("second")
    first, second = events(lines, SENT)
    assert first.startswith("waiting notifies: first (only in the log; the table [notify]")
    assert second == "waiting notifies: second"
    assert [one.message for one in house.notifications] == ["first", "second"]


@pytest.mark.house(WAITING, config={"notify": {}})
async def test_of_a_flood_ten_are_sent_and_the_others_counted(lines: list[EventDict], house: VirtualHouse) -> None:
    app = washing(house.runtime)
    assert [await app.notify(f"{number}") for number in range(25)] == [True] * 10 + [False] * 15
    assert [one.count for one in house.runtime.app_host.counts()] == [15, 0]
    assert len(events(lines, DROPPED)) == 1
    await house.run_for("10s")
    assert await app.notify("later")


@pytest.mark.house(WAITING, config={"notify": {}, "gateways": {"mqtt": {"act": False}}})
async def test_a_notification_that_fails_is_logged_and_the_app_runs_on(
    lines: list[EventDict], house: VirtualHouse
) -> None:
    await house.run_for("1s")
    assert not await washing(house.runtime).notify("Washing is done")
    (line,) = events(lines, NOT_SENT)
    assert "mqtt: the gateway only observes" in line
    failure = line.removeprefix("a ").replace(" of waiting", "")
    assert [*house.runtime.app_host.problems()] == [f"the last {failure}"]
    assert house.crashed == ()


@contextmanager
def web_server() -> Iterator[tuple[int, list[dict[str, object]]]]:
    """A server that takes what apprise posts; it refuses what is for ``/no``."""
    posted: list[dict[str, object]] = []

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"]))
            posted.append(json.loads(body) | {"X-Priority": self.headers["X-Priority"]})
            self.send_response(500 if self.path.startswith("/no") else 200)
            self.end_headers()

        def log_message(self, *_: object) -> None:
            """Log nothing."""

    server = HTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, args=(0.01,))
    thread.start()
    try:
        yield server.server_port, posted
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


@contextmanager
def clock_stopped() -> Iterator[None]:
    """No limit ends inside the block: a slow machine may take half a minute to load apprise."""
    loop = asyncio.get_running_loop()
    now = loop.time()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loop, "time", lambda: now)
        yield


async def notified(urls: list[str]) -> tuple[bool, str]:
    """Return whether an app notified by *urls*, and the trouble."""
    config = parse_config({"notify": {"urls": urls}, "apps": {"waiting": {"class": WAITING}}, "door": {"port": 0}}, "t")
    async with Runtime(config, with_door=False) as runtime:
        with clock_stopped():
            is_sent = await washing(runtime).notify("Washing is done", title="Cellar")
        return is_sent, runtime.app_host.notifier.trouble


_WARNS = pytest.mark.filterwarnings("ignore::DeprecationWarning")
"""By apprise."""


@pytest.mark.newest("apprise")
@_WARNS
async def test_apprise_sends_a_notification_to_a_real_server() -> None:
    with web_server() as (port, posted):
        assert await notified([f"json://user:{SECRET}@127.0.0.1:{port}/"]) == (True, "")
    assert (posted[0]["title"], posted[0]["message"]) == ("Cellar", "Washing is done")


@_WARNS
async def test_a_kind_and_an_urgency_have_addresses_and_priorities_of_their_own() -> None:
    """As a server of ntfy gets them."""
    with web_server() as (port, posted):

        def url(topic: str) -> str:
            return f"ntfy://127.0.0.1:{port}/{topic}"

        by = {"high": [url("phone"), url("siren")], "battery": [url("list")], "door": []}
        table = {"urls": [url("house")], "urls_by": by}
        config = parse_config({"notify": table, "apps": {"waiting": {"class": WAITING}}, "door": {"port": 0}}, "t")
        async with Runtime(config, with_door=False) as runtime:
            notify = runtime.app_host.context.notify
            with clock_stopped():
                assert await notify("Washing is done", "", "waiting")
                assert await notify("Hall reports smoke", "Alert", "alerts", "high", "smoke")
                assert await notify("Sink has a weak battery", "Alert", "alerts", "low", "battery")
                assert await notify("Hall is open", "Alert", "alerts", "normal", "door")
    got = [(one["topic"], one["X-Priority"], one["message"]) for one in posted]
    assert got == [
        ("house", None, "Washing is done"),
        ("phone", "max", "Hall reports smoke"),
        ("siren", "max", "Hall reports smoke"),
        ("list", "low", "Sink has a weak battery"),
    ]


@_WARNS
async def test_no_line_of_the_log_and_no_error_has_an_address(
    lines: list[EventDict], caplog: pytest.LogCaptureFixture
) -> None:
    with web_server() as (port, posted):
        urls = [f"json://user:{SECRET}@127.0.0.1:{port}/no", f"jsn://{SECRET}", f"tgram://{SECRET}/x"]
        is_sent, trouble = await notified(urls)
    assert not is_sent
    assert len(posted) == 1
    assert trouble == (
        "JSON (notify.urls[0]) did not answer, or refused it; notify.urls[1] is not an address that apprise knows; "
        "notify.urls[2] is not an address that apprise knows"
    )
    assert SECRET not in f"{lines} {caplog.text}"


@pytest.mark.parametrize(
    ("table", "problem"),
    [
        ({"gateway": "mqqt"}, "notify.gateway: there is no gateway 'mqqt'"),
        ({"topic": "a/#"}, "notify.topic: "),
        ({"urls": [SECRET, 1]}, "notify.urls.1: "),
        ({"urls_by": {"smok": []}}, "notify.urls_by.smok"),
        ({"topc": "a"}, "did you mean topic?"),
    ],
)
def test_a_wrong_table_is_an_error_that_names_the_key(table: dict[str, object], problem: str) -> None:
    config = parse_config({"notify": table, "gateways": {"mqtt": {}}}, "homebot.toml")
    with pytest.raises(ConfigError) as raised:
        make_plan(config)
    assert problem in str(raised.value)
    assert SECRET not in str(raised.value)


def test_urls_without_apprise_say_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    with pytest.raises(ConfigError, match=r'pip install "homebot\[apprise\]"'):
        make_plan(parse_config({"notify": {"urls": ["json://x"]}}, "homebot.toml"))


def test_in_a_test_nothing_is_sent_to_people() -> None:
    given = parse_config({"notify": {"urls": ["json://x"], "topic": "home/say"}}, "homebot.toml")
    made: Config = house_config((), "home", "mqtt://127.0.0.1:1", given)
    assert made.notify == {"topic": "home/say"}


@pytest.mark.homebot(WAITING, config={"notify": {"topic": "home/say"}})
async def test_notifications_of_a_homebot_in_real_time_are_kept_too(homebot: TestHouse) -> None:
    assert await washing(homebot.runtime).notify("Washing is done")
    assert json.loads(await homebot.hears("home/say"))["message"] == "Washing is done"
    assert [one.message for one in homebot.notifications] == ["Washing is done"]
