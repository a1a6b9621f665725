"""The driver for things over HTTP, with a simulated thing and with servers of the test's."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import anyio
import pytest
from aiohttp import web
from pydantic import ValidationError
from tests.gateways.drivers.driver_host import KeepingHost, command, found, running
from tests.gateways.http_servers import serving
from tests.gateways.served import served
from tests.things.thing import ServedThing

from homebot.errors import RefusedError, WireError
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.things.driver import ThingDriver
from homebot.integrations.things.driver.driver import ThingDriverSettings
from homebot.integrations.things.formats.parse import CONTEXT

WOT = "_wot._tcp.local."


class Obeying(ServedThing):
    """A lamp that does what it is told, and is dimmed and switched by others."""

    def __init__(self, **access: str) -> None:
        super().__init__(SimulatedDeviceInfo("home", "lamp", "Shelf", "lights", "hall"), self.obey, **access)  # type: ignore[arg-type]
        self.told: list[str] = []
        self.begin(DeviceState(text="off", brightness=0.4, kelvin=2700), has_power=True)

    def obey(self, text: str) -> None:
        self.told.append(text)
        is_on = text != "off"
        brightness = self.state.brightness if text in {"on", "off"} or text.endswith("K") else float(text)
        self.publish(DeviceState(text=text, is_on=is_on, brightness=brightness, kelvin=2700))


def driver(port: int, host: KeepingHost, settings: dict[str, Any] | None = None, **text: str) -> ThingDriver:
    return ThingDriver(found(WOT, port, **text), ThingDriverSettings.model_validate(settings or {}), host)


def description(**changes: Any) -> dict[str, Any]:
    return {
        "@context": CONTEXT,
        "title": "Kettle",
        "securityDefinitions": {"open": {"scheme": "nosec"}},
        "security": "open",
        "properties": {"on": {"type": "boolean", "@type": "OnOffProperty", "forms": [{"href": "/on"}]}},
    } | changes


def port_of(origin: str) -> int:
    return int(origin.rpartition(":")[2])


async def test_changes_by_others_are_pushed() -> None:
    host, lamp = KeepingHost(), Obeying()
    async with served(lamp), running(driver(lamp.server.port, host)):
        await host.until(lambda: len(lamp.server.peers) == 3)
        lamp.publish(DeviceState(text="on", is_on=True, brightness=1.0))
        await host.until(lambda: host.values.get(("", "on_off")) is True and host.values.get(("", "level")) == 100)


@pytest.mark.parametrize("scheme", ["basic", "bearer"])
async def test_a_password_is_sent_the_way_the_description_asks_for(scheme: str, tmp_path: Path) -> None:
    secret = tmp_path / "secret"
    secret.write_text("sesame\n")
    secret.chmod(0o600)
    host, lamp = KeepingHost(), Obeying(token="sesame", user="ann" if scheme == "basic" else "")
    settings = {"credentials": [{"host": "hall.local", "user": "ann", "password_file": str(secret)}]}
    async with served(lamp):
        thing = driver(lamp.server.port, host, settings)
        async with running(thing):
            await host.until(lambda: ("", "on_off") in host.values)
            await thing.perform(command("", "on_off", True, key=thing.service.key))
    assert lamp.told == ["on"]


async def test_without_its_password_the_thing_refuses_and_the_error_says_so() -> None:
    host, lamp = KeepingHost(), Obeying(token="sesame")
    async with served(lamp):
        with pytest.raises(RefusedError, match="wants a password"):
            await driver(lamp.server.port, host).run()
    assert len(host.devices) == 1


@pytest.mark.parametrize("scheme", ["apikey", "auto", "digest", "oauth2", "psk"])
async def test_a_thing_that_wants_another_way_is_listed_and_the_error_names_that(
    scheme: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("KETTLE_KEY", "sesame")
    asked: list[str] = []

    async def answer(request: web.Request) -> web.StreamResponse:
        asked.append(request.path)
        return web.json_response(description(securityDefinitions={"open": {"scheme": scheme}}))

    host = KeepingHost()
    settings = {"credentials": [{"host": "127.0.0.1", "password_env": "KETTLE_KEY"}]}
    async with serving(answer) as origin:
        with pytest.raises(RefusedError, match=f"it wants '{scheme}', which is not supported"):
            await driver(port_of(origin), host, settings).run()
    assert len(host.devices) == 1
    assert set(asked) == {"/.well-known/wot"}


@pytest.mark.parametrize("scheme", ["apikey", "digest"])
def test_a_configured_way_that_homebot_had_once_is_a_mistake_that_says_so(scheme: str) -> None:
    settings = {"credentials": [{"host": "a", "scheme": scheme, "password_env": "KEY"}]}
    with pytest.raises(ValidationError, match=f"{scheme} is gone; things get their password by basic or bearer"):
        ThingDriverSettings.model_validate(settings)


async def test_a_way_other_than_the_configured_one_gets_no_password(monkeypatch: pytest.MonkeyPatch) -> None:
    """A stranger who answers in place of the thing cannot ask for the password in clear."""
    monkeypatch.setenv("KETTLE_KEY", "sesame")
    seen: list[str | None] = []

    async def answer(request: web.Request) -> web.StreamResponse:
        if request.path != "/.well-known/wot":
            seen.append(request.headers.get("Authorization"))
        return web.json_response(description(securityDefinitions={"open": {"scheme": "basic"}}))

    settings = {"credentials": [{"host": "127.0.0.1", "scheme": "bearer", "user": "ann", "password_env": "KETTLE_KEY"}]}
    async with serving(answer) as origin:
        with pytest.raises(RefusedError, match="bearer is configured"):
            await driver(port_of(origin), KeepingHost(), settings).run()
    assert seen == []


@pytest.mark.parametrize("claimed", ["192.0.2.7.", "lamp.example.org."])
async def test_a_claimed_address_or_name_of_the_internet_gets_no_password(
    claimed: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SECRET", "sesame")
    settings = {"credentials": [{"host": claimed.removesuffix("."), "scheme": "bearer", "password_env": "SECRET"}]}
    seen: list[str | None] = []

    async def answer(request: web.Request) -> web.StreamResponse:
        seen.append(request.headers.get("Authorization"))
        return web.json_response(description() if request.path.endswith("wot") else True)

    host = KeepingHost()
    async with serving(answer) as origin:
        service = replace(found(WOT, port_of(origin)), host=claimed)
        async with running(ThingDriver(service, ThingDriverSettings.model_validate(settings), host)):
            await host.until(lambda: ("", "on_off") in host.values)
    assert set(seen) == {None}


async def test_forms_that_lead_to_other_hosts_are_not_used() -> None:
    """A stranger's description must not make homebot ask, or switch, what the stranger cannot reach."""
    asked: list[str] = []

    async def other(request: web.Request) -> web.StreamResponse:
        asked.append(request.path)
        return web.json_response(True)

    async with serving(other) as target:
        elsewhere = target.replace("127.0.0.1", "localhost")

        async def answer(request: web.Request) -> web.StreamResponse:
            form = {"href": f"{elsewhere}/on"}
            power = {"type": "number", "forms": [{"href": "/power"}], "@type": "InstantaneousPowerProperty"}
            on = {"type": "boolean", "@type": "OnOffProperty", "forms": [form]}
            body: object = description(properties={"on": on, "power": power})
            return web.json_response(body if request.path.endswith("wot") else 5)

        host = KeepingHost()
        async with serving(answer) as origin, running(driver(port_of(origin), host)):
            await host.until(lambda: 5 in host.values.values())
    assert asked == []


async def test_addresses_by_the_name_of_the_host_are_reached_without_a_name_server() -> None:
    async def answer(request: web.Request) -> web.StreamResponse:
        if request.path == "/lamp/td":
            port = request.url.port
            return web.json_response(description(base=f"http://HALL.local:{port}/"))
        return web.json_response(True)

    host = KeepingHost()
    async with serving(answer) as origin, running(driver(port_of(origin), host, td="/lamp/td")):
        await host.until(lambda: host.values.get(("", "on_off")) is True)


async def test_an_action_is_posted_and_an_event_is_reported() -> None:
    posted: list[str] = []
    over = anyio.Event()

    async def answer(request: web.Request) -> web.StreamResponse:
        if request.path == "/.well-known/wot":
            actions = {"boil": {"forms": [{"href": "/boil"}]}}
            events = {"boiled": {"data": {"type": "string"}, "forms": [{"href": "/boiled", "subprotocol": "sse"}]}}
            return web.json_response(description(actions=actions, events=events))
        if request.path == "/boiled":
            stream = web.StreamResponse(headers={"Content-Type": "text/event-stream"})
            await stream.prepare(request)
            await stream.write(b'event: boiled\ndata: "hot"\n\n')
            await over.wait()
            return stream
        if request.path == "/boil":
            posted.append(request.method)
            return web.Response(status=204)
        return web.json_response(True)

    host = KeepingHost()
    async with serving(answer) as origin:
        thing = driver(port_of(origin), host)
        async with running(thing):
            await host.until(lambda: ("boiled", "press", "hot") in host.events)
            await thing.perform(command("boil", "push", True, key=thing.service.key))
        over.set()
    assert posted == ["POST"]


async def test_of_a_directory_only_its_place_is_told() -> None:
    async def answer(_: web.Request) -> web.StreamResponse:
        return web.json_response(description(**{"@type": "ThingDirectory"}))

    host = KeepingHost()
    async with serving(answer) as origin, running(driver(port_of(origin), host, type="Directory")):
        await host.until(lambda: bool(host.devices))
    assert (host.device.parts, host.device.metadata["thing_directory"]) == ((), origin)


@pytest.mark.parametrize(
    ("body", "kind"),
    [(b"{", "application/td+json"), (b"{}", "application/json"), (b"<html>", "text/html"), (b"[]", "")],
)
async def test_an_invalid_description_is_an_error(body: bytes, kind: str) -> None:
    async def answer(_: web.Request) -> web.StreamResponse:
        return web.Response(body=body, headers={"Content-Type": kind} if kind else {})

    async with serving(answer) as origin:
        with pytest.raises(WireError):
            await driver(port_of(origin), KeepingHost()).run()
