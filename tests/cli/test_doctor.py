"""Findings of the doctor: of a gateway, of a node, and before the start."""

import json
import re
import socket
import sqlite3
from collections.abc import Callable, Iterator
from itertools import chain, starmap
from pathlib import Path
from typing import cast

import pytest
from tests.cli.conftest import NOW, Homebot
from tests.cli.golden.conftest import StillHouse, ago, attic, told

from homebot.bridges.rosapi.doctor import gateway_finding, health_findings
from homebot.cli import main
from homebot.cli.commands.doctor import print_finding
from homebot.clock import ManualClock
from homebot.devices import QUERY_DEVICES, Fact, GatewayState, QueryDevices
from homebot.devices.findings import FindingKind
from homebot.devices.health import Count, HealthRequest, HealthResponse, PartFailure
from homebot.devices.part import Part
from homebot.discovery.store import index_path
from homebot.graph import Graph, Node
from homebot.messages import Time
from homebot.support.counters import Severity

Text = pytest.CaptureFixture[str]


def findings(output: str) -> dict[str, dict[str, object]]:
    return {one["code"]: one for one in json.loads(output)["findings"]}


@pytest.mark.parametrize(
    ("state", "line"),
    [
        (None, "HB301 gateway ble does not report its state"),
        (GatewayState(state="active", reason="another acts", acts=False), ""),
        (
            GatewayState(state="unavailable", reason=f"there is no D-Bus; {'then ' * 100}", acts=True),
            f"HB302 gateway ble is unavailable: there is no D-Bus; {'then ' * 100}",
        ),
    ],
)
def test_a_gateway_that_is_unavailable_is_not_said_to_send_commands(
    capsys: Text, state: GatewayState | None, line: str
) -> None:
    found = list(gateway_finding("ble", state))
    assert len(found) == bool(line)
    assert all(one.is_problem for one in found)
    for one in found:
        print_finding(one)
    assert capsys.readouterr().out.partition("\n")[0] == line


def test_a_count_that_alone_makes_all_not_well_has_a_code_of_its_own(capsys: Text) -> None:
    """Who reads "problems found" at the end is to see which line is meant."""
    losses = Count.each({"commands_failed": 1, "inbox_dropped": 7, "reports_lost": 0}, Severity.LOSS)
    faults = Count.each({"announcements_rejected": 2}, Severity.FAULT)
    health = HealthResponse(counts=(*faults, *losses, Count(name="lost_and_dropped_by_a_name_alone", count=3)))
    found = list(health_findings("gateway/mqtt", health, 0.0, everything=False))
    assert [one.is_problem for one in found] == [True, False]
    for one in found:
        print_finding(one)
    assert [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()] == [
        "HB204 counted by gateway/mqtt in the last ten minutes:",
        "commands failed 1",
        "inbox dropped 7",
        "→ the log and homebot journal tell more",
        "HB207 counted by gateway/mqtt since it started:",
        "announcements rejected 2",
    ]


def test_a_handler_that_failed_is_one_finding() -> None:
    """The count alone would be a loss, of which the journal tells nothing."""
    failure = PartFailure(
        part="hall", what="the handler light failed", count=2, last=Time.from_seconds(0.0), why="ValueError: no lamp"
    )
    health = HealthResponse(counts=Count.each({"callback_failures": 2}), failures=(failure,))
    assert [one.code for one in health_findings("homebot", health, 0.0, everything=False)] == [FindingKind.FAILURE.code]
    assert len([*health_findings("homebot", health, 0.0, everything=True)]) == 2


def test_every_code_is_once_in_the_guide() -> None:
    guide = (Path(__file__).parents[2] / "docs" / "operate.md").read_text()
    assert re.findall(r"^\| (HB\d+) \|", guide, re.MULTILINE) == sorted(one.code for one in FindingKind)
    assert len({one.code for one in FindingKind}) == len(list(FindingKind))


@pytest.mark.rooms("alerts")
def test_a_weak_battery_is_a_problem_and_a_device_without_room_is_none(
    homebot_with: Callable[..., Homebot], capsys: Text
) -> None:
    class Weak(StillHouse):
        def _devices(self) -> tuple:  # type: ignore[type-arg]
            states = (told("", "battery", 7.4, 5), told("", "battery_low", True, 5))
            one = attic().model_copy(update={"states": states, "reachable": super()._devices()[0].reachable})
            robot = one.parts[0].model_copy(update={"part": Part(id="", service_type="x_robot")})
            rosie = one.model_copy(update={"id": "rosie", "area": "", "parts": (robot,), "states": ()})
            return one.model_copy(update={"area": ""}), rosie

    still = Weak()
    still.is_well = True
    homebot = homebot_with(still.node, None)
    assert main(["--door", homebot.door, "doctor", "--json"]) == 1
    found = findings(capsys.readouterr().out)
    assert found["HB404"]["rows"] == [{"what": "attic", "why": "has a weak battery (7 %)"}]
    assert [one["is_problem"] for one in found.values()] == [True, False, False, False]
    assert found["HB405"]["rows"] == [{"what": "attic", "why": "Attic"}]


def test_what_a_device_sent_and_nobody_understood_is_a_problem_for_a_day(
    homebot_with: Callable[..., Homebot], capsys: Text
) -> None:
    class Mistaken(StillHouse):
        seconds = 3_600.0

        def _devices(self) -> tuple:  # type: ignore[type-arg]
            text = "payloads on attic: 2, the last 'on': expects ON or OFF"
            fact = Fact(
                name="unreadable", value=text, gateway="mqtt", convention="", key="a", said_at=ago(self.seconds)
            )
            earlier = fact.model_copy(update={"said_at": ago(self.seconds + 60), "value": "payloads on other: 1"})
            one = attic().model_copy(update={"facts": (earlier, fact), "reachable": super()._devices()[0].reachable})
            return (one,)

    still = Mistaken()
    still.is_well = True
    homebot = homebot_with(still.node, ManualClock(NOW))
    assert main(["--door", homebot.door, "doctor", "--json"]) == 1
    (row,) = cast("list[dict[str, str]]", findings(capsys.readouterr().out)["HB407"]["rows"])
    assert row["what"] == "attic"
    assert row["why"].startswith("1 h ago: payloads on attic: 2, the last 'on': expects ON or OFF (and 1 more: ")
    still.seconds = 90_000.0
    assert main(["--door", homebot.door, "doctor", "--json"]) == 0
    assert "HB407" not in findings(capsys.readouterr().out)


@pytest.mark.rooms("homeassistant", "homekit", "hue")
def test_what_mdns_found_and_no_gateway_uses_is_no_problem_and_has_its_next_step(
    homebot_with: Callable[..., Homebot], capsys: Text
) -> None:
    """A Hue bridge is a HomeKit accessory as well, and stays one while the gateway for Hue uses it."""

    class Unused(StillHouse):
        def _devices(self) -> tuple:  # type: ignore[type-arg]
            hall = (("homekit", "pair it", "_hap._tcp"),)
            bridge = (*hall, ("hue", "press its button", "_hue._tcp"))
            in_use = (*hall, ("", "", "_hue._tcp"))
            found = {"hall": hall, "bridge": bridge, "in use": in_use}
            return tuple(
                attic().model_copy(update={"id": name, "facts": tuple(chain.from_iterable(starmap(facts_of, one)))})
                for name, one in found.items()
            )

    def facts_of(needed: str, step: str, kind: str) -> Iterator[Fact]:
        for name, value in (("dns_sd_type", kind), ("needs_gateway", needed), ("next_step", step)):
            if value:
                yield Fact(name=name, value=value, gateway="mdns", convention="", key=kind, said_at=ago(5))

    homebot = homebot_with(Unused().node, None)
    main(["--door", homebot.door, "doctor", "--json"])
    finding = findings(capsys.readouterr().out)["HB406"]
    assert finding["is_problem"] is False
    assert finding["rows"] == [{"what": "bridge", "why": "press its button"}, {"what": "hall", "why": "pair it"}]


@pytest.mark.rooms("valetudo")
def test_a_vacuum_that_is_no_robot_has_the_table_that_makes_it_one(
    homebot_with: Callable[..., Homebot], capsys: Text
) -> None:
    class WithVacuum(StillHouse):
        def _devices(self) -> tuple:  # type: ignore[type-arg]
            fact = Fact(name="origin", value="Valetudo", gateway="mqtt", convention="", key="a", said_at=ago(5))
            (one,) = attic().parts[:1]
            part = one.part.model_copy(update={"reads": ("valetudo/Big Dog/hass/state",)})
            parts = (one.model_copy(update={"part": part}),)
            return (attic().model_copy(update={"facts": (fact,), "parts": parts}),)

    homebot = homebot_with(WithVacuum().node, None)
    main(["--door", homebot.door, "doctor", "--json"])
    finding = findings(capsys.readouterr().out)["HB409"]
    assert finding["is_problem"] is False
    assert finding["rows"] == [{"what": "attic", "why": 'add [robots.big_dog] with vacuum = "valetudo/Big Dog"'}]


def test_a_homebot_without_a_gateway_is_told_how_to_get_one(homebot_with: Callable[..., Homebot], capsys: Text) -> None:
    """A configuration of tokens alone found no device, and all was well."""

    def devices_alone(graph: Graph) -> Node:
        node = Node(graph, "still")
        node.create_service(QueryDevices, QUERY_DEVICES, StillHouse()._query)
        return node

    homebot = homebot_with(devices_alone, None)
    assert main(["--door", homebot.door, "doctor", "--gateways"]) == 0
    second = capsys.readouterr().out.splitlines()[1]
    assert second == "no gateway runs; one with a table such as [gateways.mqtt] finds devices"


def test_a_container_is_healthy_though_devices_are_silent_and_parts_have_failed(
    homebot_with: Callable[..., Homebot], capsys: Text
) -> None:
    homebot = homebot_with(StillHouse().node, None)
    assert main(["--door", homebot.door, "doctor"]) == 1
    assert main(["--door", homebot.door, "doctor", "--gateways"]) == 0
    assert "HB" not in capsys.readouterr().out.rpartition("gateway mqtt")[2]


def test_a_part_that_cannot_say_how_it_is_is_a_finding(homebot_with: Callable[..., Homebot], capsys: Text) -> None:
    """It ended the whole report."""

    class Broken(StillHouse):
        def _health(self, request: HealthRequest) -> HealthResponse:
            raise ValueError(f"no answer to {request}")

    homebot = homebot_with(Broken().node, None)
    assert main(["--door", homebot.door, "doctor"]) == 1
    problem = "service /gateway/mqtt/health failed: ValueError"
    assert f"HB201 problem of gateway/mqtt: {problem}" in capsys.readouterr().out


def offline(capsys: Text, *words: str) -> tuple[int, dict[str, dict[str, object]]]:
    code = main(["doctor", "--offline", "--json", *words])
    return code, findings(capsys.readouterr().out)


def why(finding: dict[str, object]) -> str:
    (row,) = cast("list[dict[str, str]]", finding["rows"])
    return f"{row['what']} {row['why']}".strip()


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOMEBOT_DATA", str(tmp_path / "data"))
    (tmp_path / "homebot.toml").write_text('[gateways.mqtt]\nurl = "mqtt://127.0.0.1:1"\n[door]\nport = 0\n')
    return tmp_path


def test_before_the_start_all_is_well_where_nothing_is_missing(folder: Path, capsys: Text) -> None:
    assert main(["doctor", "--offline"]) == 0
    assert capsys.readouterr().out == "checked homebot.toml and what it needs\n\nall is well\n"
    assert not (folder / "data").exists()  # it looks, and makes nothing


def test_before_the_start_the_configuration_and_its_secrets_are_checked(folder: Path, capsys: Text) -> None:
    (folder / "token").write_text("abc")
    (folder / "token").chmod(0o644)
    (folder / "homebot.toml").write_text('[gateways.mqtt]\nurll = "x"\n[door]\ntoken_file = "token"\n')
    code, found = offline(capsys)
    assert code == 1
    assert why(found["HB101"]) == "homebot.toml:2: gateways.mqtt.urll: unknown key; did you mean url or user?"
    assert why(found["HB106"]).startswith("token can be read by others")
    assert main(["doctor", "--offline"]) == 1
    assert "HB101 wrong configuration: homebot.toml:2: gateways.mqtt.urll" in capsys.readouterr().out


def test_before_the_start_a_missing_extra_is_named_with_its_command(
    folder: Path, capsys: Text, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "homebot.toml").write_text("[gateways.mdns]\n")
    monkeypatch.setattr("importlib.util.find_spec", lambda _name: None)
    code, found = offline(capsys)
    assert code == 1
    assert 'pip install "homebot[mdns]"' in why(found["HB102"])
    assert "HB101" not in found


def test_before_the_start_a_taken_port_and_a_silent_broker_are_found(folder: Path, capsys: Text) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        (folder / "homebot.toml").write_text(f'[gateways.mqtt]\nurl = "mqtt://127.0.0.1:1"\n[door]\nport = {port}\n')
        code, found = offline(capsys)
        assert (code, set(found)) == (1, {"HB105"})
        assert f"127.0.0.1:{port} is in use" in why(found["HB105"])
        _, found = offline(capsys, "--reach")
        assert "nothing is listening there" in why(found["HB107"])


@pytest.mark.usefixtures("folder")
def test_before_the_start_a_file_of_a_newer_homebot_is_found(capsys: Text) -> None:
    kept = index_path("home", "127.0.0.1:1").parent
    kept.mkdir(parents=True, mode=0o700)
    connection = sqlite3.connect(kept / "index.sqlite")
    connection.execute("PRAGMA user_version = 99")
    connection.close()
    (kept / "journal.sqlite").write_bytes(b"no database at all")
    code, found = offline(capsys)
    assert code == 1
    rows = {Path(one["what"]).name: one["why"] for one in found["HB104"]["rows"]}  # type: ignore[attr-defined]
    assert rows["index.sqlite"].startswith("was written by a newer homebot (version 99")
    assert rows["journal.sqlite"] == "it is no file of SQLite"


def test_before_the_start_a_folder_that_is_none_is_found(folder: Path, capsys: Text) -> None:
    (folder / "data").write_text("")
    code, found = offline(capsys)
    assert code == 1
    assert f"{folder / 'data'} cannot be written" in why(found["HB103"])


def test_options_of_the_check_before_the_start_need_it(capsys: Text) -> None:
    assert main(["doctor", "--reach"]) == 1
    assert "--config and --reach are for --offline" in capsys.readouterr().err
