"""The driver against simulated devices, which are real servers of the native API on loopback."""

import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path

import anyio
import pytest
from pydantic import ValidationError
from tests.gateways.drivers.driver_host import KeepingHost, command, night
from tests.integrations.esphome.driver.served import KEY, OTHER_KEY, driven, living, service_of, simulated
from tests.integrations.esphome.simulated.device import EsphomeServedDevice
from tests.patience import PATIENCE

from homebot.devices.gateway_messages import REACHABLE, Report
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, UnableError, UsageError, WireError
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.drivers.driver_runner import DriverRunner, UsableDriver
from homebot.gateways.memory import MemoryGateway
from homebot.graph import Graph, Node, Subscription
from homebot.house.dialect import DeviceState
from homebot.integrations.esphome.driver import EsphomeDriver, EsphomeSettings
from homebot.integrations.esphome.driver.driver import StateQueue
from homebot.integrations.esphome.driver.settings import EsphomeSecrets
from homebot.integrations.esphome.formats.device import EsphomeDevice

LAMP = "light_lamp"


def settings(tmp_path: Path, key: str, *, device: str = "") -> EsphomeSettings:
    file = tmp_path / "key"
    file.write_text(f"{key}\n")
    file.chmod(0o600)
    if device:
        return EsphomeSettings(devices={device: EsphomeSecrets(key_file=file)})
    return EsphomeSettings(key_file=file)


async def failure(device: EsphomeServedDevice, given: EsphomeSettings, txt: dict[str, str] | None = None) -> str:
    """The error with which a driver of *device* ends, in words."""
    service = service_of(device)
    async with driven(service if txt is None else replace(service, properties=txt), given) as run:
        error = await run.failure()
    assert isinstance(error, RefusedError)
    assert not isinstance(error, UnableError)
    return str(error)


async def told_to(told: list[str], text: str) -> None:
    with anyio.fail_after(PATIENCE):
        while text not in told:  # noqa: ASYNC110 - a device tells nobody what it was told
            await anyio.sleep(0.01)


async def test_a_device_is_described_with_name_area_and_address() -> None:
    device = simulated("lamp", [])
    async with living(device), driven(service_of(device)) as run:
        await run.until_reported()
    found = run.host.device
    assert (found.name, found.area, found.identifiers) == ("hall", "Hall", (f"mac:{device.mac}",))
    assert found.metadata == {"manufacturer": "homebot", "model": "simulated lamp", "sw_version": "2026.10.0"}
    (part,) = found.parts
    assert (part.id, part.service_type) == (LAMP, "light")


@pytest.mark.parametrize(
    ("kind", "state", "part", "values"),
    [
        (
            "lamp",
            DeviceState(text="on", is_on=True, brightness=0.5, kelvin=4000.0),
            LAMP,
            {"on_off": True, "level": 50.0, "color_temperature": 4000.0},
        ),
        ("motion", DeviceState(text="motion"), "binary_sensor_motion", {"occupancy": True}),
        (
            "thermostat",
            DeviceState(text="20", celsius=19.44, target=21.0, heats=True),
            "climate_thermostat",
            {"local_temperature": 19.4, "heating_setpoint": 21.0, "thermostat_action": "heating"},
        ),
    ],
)
async def test_states_are_reported_when_it_connects_and_when_they_change(
    kind: str, state: DeviceState, part: str, values: dict[str, PlainValue]
) -> None:
    device = simulated(kind, [])
    async with living(device), driven(service_of(device)) as run:
        await run.until_reported()
        device.publish(state)
        known = run.host.values
        await run.host.until(lambda: all(known.get((part, name)) == value for name, value in values.items()))
    assert (run.host.rejected, run.host.refused) == ([], [])


@pytest.mark.parametrize(
    ("kind", "part", "capability", "value", "text"),
    [
        ("lamp", LAMP, "on_off", True, "on"),
        ("lamp", LAMP, "on_off", False, "off"),
        ("cover", "cover_cover", "position", 25.0, "0.25"),
        ("lock", "lock_lock", "lock", "locked", "lock"),
        ("thermostat", "climate_thermostat", "heating_setpoint", 21.5, "21.5"),
    ],
)
async def test_commands_are_obeyed(kind: str, part: str, capability: str, value: float | str, text: str) -> None:
    told: list[str] = []
    device = simulated(kind, told)
    async with living(device), driven(service_of(device)) as run:
        await run.until_reported()
        await run.driver.perform(command(part, capability, value))
        await told_to(told, text)


async def test_one_message_sets_all_that_a_lamp_shall_be() -> None:
    told: list[str] = []
    device = simulated("lamp", told)
    async with living(device), driven(service_of(device)) as run:
        await run.until_reported()
        assert set(await run.driver.perform(night(LAMP))) == {"level", "color_temperature", "on_off"}
        await told_to(told, "0.03")
    assert told == ["2700 K", "0.03"]


async def test_an_impossible_command_is_refused() -> None:
    device = simulated("lock", [])
    async with living(device), driven(service_of(device)) as run:
        await run.until_reported()
        with pytest.raises(RefusedError, match="it takes unlocked, locked"):
            await run.driver.perform(command("lock_lock", "lock", "open"))
        with pytest.raises(RefusedError, match="no such part"):
            await run.driver.perform(command("lock_other", "lock", "locked"))


async def test_an_encrypted_device_is_read_and_commanded_with_its_key(tmp_path: Path) -> None:
    told: list[str] = []
    device = simulated("lamp", told, key=KEY)
    async with living(device), driven(service_of(device), settings(tmp_path, KEY)) as run:
        await run.until_reported()
        device.publish(DeviceState(text="on", is_on=True))
        await run.host.until(lambda: run.host.values[LAMP, "on_off"] is True)
        await run.driver.perform(command(LAMP, "on_off", False))
        await told_to(told, "off")


async def test_another_key_is_refused_with_what_to_do_and_is_in_no_text(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, capsys: pytest.CaptureFixture[str]
) -> None:
    caplog.set_level(logging.DEBUG)
    device = simulated("lamp", [], key=KEY)
    async with living(device):
        error = await failure(device, settings(tmp_path, OTHER_KEY))
    assert error == (
        "the connection to home-hall was refused: it wants another encryption key; put the key that its ESPHome "
        'configuration has under "api: encryption: key:" into a file, and name that in '
        '[gateways.mdns.drivers.esphome.devices."home-hall"] as key_file'
    )
    printed = capsys.readouterr()
    assert OTHER_KEY not in error + caplog.text + printed.out + printed.err
    assert device.logins == 1


async def test_an_encrypted_device_without_a_key_is_not_even_tried() -> None:
    device = simulated("lamp", [], key=KEY)
    async with living(device):
        assert "it wants encryption; put the key" in await failure(device, EsphomeSettings())
        assert device.logins == 0
        assert "it wants encryption; put the key" in await failure(device, EsphomeSettings(), txt={})


async def test_a_device_with_a_key_of_its_own_is_not_talked_to_in_the_clear(tmp_path: Path) -> None:
    """Else whoever announces its name would get its commands."""
    device = simulated("lamp", [])
    async with living(device):
        error = await failure(device, settings(tmp_path, KEY, device=device.name))
    assert 'it does not encrypt; add "api: encryption:"' in error


async def test_the_key_of_all_does_not_keep_out_a_device_that_has_none(tmp_path: Path) -> None:
    device = simulated("lamp", [])
    async with living(device), driven(service_of(device), settings(tmp_path, KEY)) as run:
        await run.until_reported()


async def test_old_firmware_gets_its_password_at_its_fixed_address_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ESPHOME_PASSWORD", "sesame")
    device = simulated("lamp", [], password="sesame")
    there, elsewhere = (
        EsphomeSettings(
            devices={device.name: EsphomeSecrets(password_env="ESPHOME_PASSWORD", allow_plaintext_at=address)}
        )
        for address in ("127.0.0.1", "192.0.2.7")
    )
    async with living(device):
        async with driven(service_of(device), there) as run:
            await run.until_reported()
        logins = device.logins
        error = await failure(device, elsewhere)
        assert "it is announced at 127.0.0.1, and its allow_plaintext_at is 192.0.2.7" in error
        assert device.logins == logins, "nothing was sent"
        monkeypatch.setenv("ESPHOME_PASSWORD", "tahini")
        error = await failure(device, there)
    assert "it wants another password; put the one" in error
    assert "tahini" not in error


def test_a_password_without_encryption_is_refused_with_what_to_do() -> None:
    for given in ({"password_env": "X"}, {"devices": {"hall": {"password_env": "X"}}}):
        with pytest.raises(ValidationError, match="would be sent unencrypted to whoever announces the device: add"):
            EsphomeSettings.model_validate(given)
    with pytest.raises(ValidationError, match="allow_plaintext_at belongs to one device"):
        EsphomeSettings(password_env="X", allow_plaintext_at="192.0.2.7")
    with pytest.raises(ValidationError, match="names can be announced by anybody"):
        EsphomeSecrets(password_env="X", allow_plaintext_at="hall.local")
    with pytest.raises(ValidationError, match="remove allow_plaintext_at"):
        EsphomeSecrets(key_env="X", allow_plaintext_at="192.0.2.7")


async def test_a_device_proves_by_its_key_that_it_is_the_owners(tmp_path: Path) -> None:
    for key, proves in ((KEY, True), ("", False)):
        device = simulated("lamp", [], key=key)
        given = settings(tmp_path, key) if key else EsphomeSettings()
        async with living(device), driven(service_of(device), given) as run:
            await run.until_reported()
            assert run.host.device.authenticated is proves


async def test_the_password_of_all_is_not_sent_in_the_clear_where_there_is_a_key_of_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else whoever announces any device without encryption reads it."""
    monkeypatch.setenv("ESPHOME_PASSWORD", "tahini")
    given = settings(tmp_path, KEY).model_copy(update={"password_env": "ESPHOME_PASSWORD"})
    device = simulated("lamp", [], password="sesame")  # it refuses a wrong password, and lets in who sends none
    async with living(device), driven(service_of(device), given) as run:
        await run.until_reported()


@asynccontextmanager
async def kept_connected(device: EsphomeServedDevice) -> AsyncIterator[tuple[DriverRunner, Subscription[Report]]]:
    """Run the driver of *device* again and again inside the block; yields what does, and the reports."""
    graph, service = Graph(), service_of(device)
    async with (
        Node(graph, "memory", namespace="/gateway") as node,
        Node(graph, "watcher") as watcher,
        anyio.create_task_group() as tasks,
    ):
        gateway = MemoryGateway(node)
        await tasks.start(gateway.serve)

        def publish(described: GatewayDevice | None, why: str) -> None:
            gateway.devices.put(described or GatewayDevice(service.key, service.name), why)

        driver = UsableDriver("esphome", EsphomeDriver, EsphomeSettings())
        runner = DriverRunner(driver, service, gateway.devices, publish)
        reports = watcher.create_subscription(Report, gateway.names.readings, qos_profile=1000)
        tasks.start_soon(runner.run)
        yield runner, reports
        tasks.cancel_scope.cancel()


async def reported(reports: Subscription[Report], capability: str, value: PlainValue) -> None:
    """Wait for a report of a value."""
    with anyio.fail_after(PATIENCE):
        while (capability, value) not in {
            (one.capability, one.value.plain()) for one in (await reports.receive()).readings
        }:
            pass


async def test_a_device_that_goes_to_sleep_is_not_unreachable_and_is_met_when_it_wakes_up() -> None:
    """It is not connected meanwhile: it would be kept for ever if it never woke up."""
    device = simulated("contact", [])
    device.sleeps = True
    async with living(device), kept_connected(device) as (runner, reports):
        await reported(reports, "contact", value=False)
        assert runner.is_connected
        device.sleep()
        await reported(reports, REACHABLE, value=None)
        assert not runner.is_connected
        await reported(reports, REACHABLE, value=True)
        assert device.logins == 2


async def test_a_device_that_sleeps_says_so_and_is_missed_after_a_day() -> None:
    device = simulated("contact", [])
    device.sleeps = True
    async with living(device), driven(service_of(device)) as run:
        await run.until_reported()
        assert run.host.device.sleeps
        assert run.host.device.stale_after == 86_400.0


async def test_a_server_that_speaks_something_else_is_no_device() -> None:
    async def greet(stream: anyio.abc.SocketStream) -> None:
        async with stream:
            await stream.send(b"SSH-2.0-OpenSSH_9.2\r\n")

    device = simulated("lamp", [])
    listener = await anyio.create_tcp_listener(local_host="127.0.0.1")
    device.port = listener.extra(anyio.abc.SocketAttribute.local_port)  # noqa: S610 - no Django
    async with listener, anyio.create_task_group() as tasks:
        tasks.start_soon(listener.serve, greet)
        async with driven(service_of(device)) as run:
            assert isinstance(await run.failure(), WireError)
        tasks.cancel_scope.cancel()


async def test_the_driver_checks_its_secrets_before_it_starts(tmp_path: Path) -> None:
    EsphomeDriver.check(settings(tmp_path, KEY))
    with pytest.raises(UsageError, match=r"devices\.hall\.key: it is not 32 bytes in base64") as caught:
        EsphomeDriver.check(settings(tmp_path, "short", device="hall"))
    assert "short" not in str(caught.value)
    with pytest.raises(UsageError, match=r"^key_file: .* cannot be read"):
        EsphomeDriver.check(EsphomeSettings(key_file=tmp_path / "nowhere"))
    own = EsphomeSecrets(password_file=tmp_path / "nowhere", allow_plaintext_at="10.0.0.7")
    with pytest.raises(UsageError, match=r"^devices\.hall\.password_file: .* cannot be read"):
        EsphomeDriver.check(EsphomeSettings(devices={"hall": own}))


async def test_a_key_that_was_taken_away_is_refused_not_a_crash(tmp_path: Path) -> None:
    device = simulated("lamp", [], key=KEY)
    given = settings(tmp_path, KEY)
    (tmp_path / "key").unlink()
    async with living(device):
        assert "key_file: " in await failure(device, given)


def test_a_secret_has_one_place() -> None:
    with pytest.raises(ValidationError, match="give key_file or key_env, not both"):
        EsphomeSettings(key_file=Path("key"), key_env="KEY")


async def test_of_many_states_the_newest_counts_and_of_many_events_some_are_dropped_and_counted() -> None:
    host = KeepingHost()
    device = EsphomeDevice(
        {}, [("switch", {"key": 1, "object_id": "a"}), ("event", {"key": 2, "event_types": ["ring"]})]
    )
    host.describe(GatewayDevice("k", "n", device.parts()))
    queue = StateQueue(device, host)
    for number in range(10_000):
        queue.put("switch", {"key": 1, "state": number % 2 == 0})
        queue.put("event", {"key": 2, "event_type": "ring"})
        queue.put("sensor", {"key": 3, "state": 1.0})
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(queue.report_all)
        await host.until(lambda: len(host.events) == 101)
        tasks.cancel_scope.cancel()
    assert host.events[0] == ("switch_a", "on_off", False)
    assert len(host.rejected) == 9900
