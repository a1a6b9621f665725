"""What the commands about devices print, letter by letter.

The expected texts lie beside this file; to write them anew, run with ``HOMEBOT_WRITE_GOLDEN=1`` and read what changed.
"""

import json
import os
import re
from pathlib import Path

import pytest
from tests.cli.conftest import NOW, Homebot
from tests.cli.golden.conftest import Run, StillHouse
from tests.devices.handles.conftest import device, part

from homebot.cli import main
from homebot.cli.commands.import_thing import topic_level
from homebot.cli.commands.why import _print_state
from homebot.devices.health import Count, PartFailure
from homebot.errors import UsageError
from homebot.gateways.announced.counters import GatewayCounters
from homebot.integrations.things.formats.parse import CONTEXT, read_thing
from homebot.messages import Time
from homebot.mqtt.client.receiver import MqttCounters
from homebot.support.counters import Severity

HERE = Path(__file__).parent
Text = pytest.CaptureFixture[str]


def check(name: str, printed: str) -> None:
    file = HERE / f"{name}.txt"
    printed = re.sub(r"^home (.*):\d+$", r"home \1:9090", printed, flags=re.MULTILINE)
    if os.environ.get("HOMEBOT_WRITE_GOLDEN"):
        file.write_text(printed)
    assert printed == file.read_text()


def test_a_state_that_is_cut_ends_once(capsys: Text) -> None:
    values = {"temperature": 20.0, "humidity": 50.0, "pressure": 1000.0, "illuminance": 5.0, "carbon_dioxide": 400.0}
    for count, end in ((4, " lx."), (5, " lx, …")):
        states = dict(list(values.items())[:count])
        _print_state(device("attic", part("x_sensor", reads=states), states=states))
        assert capsys.readouterr().out.removesuffix("\n").endswith(end)


@pytest.mark.parametrize(
    ("name", "arguments", "code"),
    [
        ("devices", ["devices"], 0),
        ("devices_long", ["devices", "--long"], 0),
        ("devices_json", ["devices", "--json"], 0),
        ("find", ["find", "light", "and", "dimmable", "in", "kitchen"], 0),
        ("find_why", ["find", "--why", "in attic or light"], 0),
        ("find_limited", ["find", "--limit", "1", "not stale"], 0),
        ("find_nothing", ["find", "robot"], 1),
        ("find_unknown_area", ["find", "light in kichen"], 1),
        ("show", ["show", "kitchen-lamp"], 0),
        ("show_by_name", ["show", "ATTIC"], 0),
        ("show_without_parts", ["show", "windows/bath"], 0),
        ("show_td", ["show", "kitchen-lamp", "--td", "--broker", "mqtt://192.168.1.10:1883"], 0),
        pytest.param("doctor", ["doctor"], 1, marks=pytest.mark.rooms("alerts")),
        pytest.param("doctor_counts", ["doctor", "--counts"], 1, marks=pytest.mark.rooms("alerts")),
    ],
)
def test_commands_print_what_they_should(run: Run, capsys: Text, name: str, arguments: list[str], code: int) -> None:
    assert run(*arguments) == code
    out, err = capsys.readouterr()
    assert err == ""
    check(name, out)


def test_devices_fit_a_hundred_columns_without_a_terminal(run: Run, capsys: Text) -> None:
    assert run("devices") == 0
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 100


def test_a_name_may_stand_in_quotation_marks_and_a_search_of_nothing_finds_all(run: Run, capsys: Text) -> None:
    printed = []
    for command in (["show", "kitchen-lamp"], ["show", '"Kitchen-Lamp"'], ["find"], ["devices"]):
        assert run(*command) == 0
        printed.append(capsys.readouterr().out)
    assert printed[0] == printed[1]
    searched, listed = ({line.split()[0] for line in text.splitlines()[1:]} for text in printed[2:])
    assert listed - searched == {"3"}, "which counts the devices"


@pytest.mark.parametrize(("query", "problem"), [("light in kichen", "'kichen'"), ("light and", "a term is missing")])
def test_a_history_of_nothing_says_why_as_a_search_does(run: Run, capsys: Text, query: str, problem: str) -> None:
    assert run("find", query) == 1
    found = "".join(capsys.readouterr()).removeprefix("homebot: ")
    assert problem in found
    assert run("history", query) == 1
    assert capsys.readouterr().err == f"homebot: {found}"


def test_a_route_through_a_gateway_that_the_owner_prefers_is_marked(still: StillHouse, run: Run, capsys: Text) -> None:
    still.prefers_hub = True
    assert run("show", "kitchen-lamp") == 0
    check("show_preferred", capsys.readouterr().out)


def test_where_nothing_is_wrong_the_doctor_says_so(still: StillHouse, run: Run, capsys: Text) -> None:
    still.is_well = True
    assert run("doctor") == 0
    check("doctor_all_well", capsys.readouterr().out)


@pytest.mark.parametrize(
    ("counted", "code"),
    [
        (Count.of(GatewayCounters(commands_refused=1)), 0),
        (Count.of(GatewayCounters(commands_failed=1)), 1),
        (Count.of(GatewayCounters(failures=1)), 1),
        (Count.of(MqttCounters(dropped_overflow=1)), 1),
        (Count.of(GatewayCounters(announcements_rejected=1)), 0),
        (Count.of(GatewayCounters(commands=1)), 0),
        (Count.each({"messages_lost": 1}), 0),
        (Count.each({"messages_lost": 1}, Severity.LOSS), 1),
        (Count.each({"messages_lost": 0}, Severity.LOSS), 0),
    ],
)
def test_what_the_house_itself_failed_at_is_enough_not_to_be_well_and_what_outsiders_did_is_not(
    still: StillHouse, run: Run, counted: tuple[Count, ...], code: int
) -> None:
    still.is_well = True
    still.counted = counted
    assert run("doctor") == code


def test_the_doctor_names_what_failed(still: StillHouse, run: Run, capsys: Text) -> None:
    still.is_well = True
    when = Time.from_seconds(NOW - 90)
    still.failures = [
        PartFailure(part="robot", what="crashed", count=5, last=when, why="ValueError: ouch\x1b", outcome="given up"),
        PartFailure(part="clock", what="the timer of 5 s failed", count=1, last=when, why="OSError: no such file"),
    ]
    assert run("doctor") == 1
    check("doctor_failures", capsys.readouterr().out)


def test_a_count_is_said_once(still: StillHouse, run: Run, capsys: Text) -> None:
    still.is_well = True
    still.counted = Count.each({"commands_failed": 3}, Severity.LOSS)
    assert run("doctor", "--json") == 1
    found = {one["code"]: one["rows"] for one in json.loads(capsys.readouterr().out)["findings"]}
    assert found["HB204"] == [{"what": "commands failed", "why": "3"}]
    assert found["HB207"] == [{"what": "announcements rejected", "why": "7"}]


@pytest.mark.rooms("alerts")
def test_the_doctor_asks_for_no_more_devices_than_it_names(still: StillHouse, run: Run, capsys: Text) -> None:
    still.crowd = 300
    assert run("doctor") == 1
    check("doctor_crowd", capsys.readouterr().out)
    assert still.carried <= 3 * 20 + 2


def test_where_no_device_was_found_the_next_step_is_named(
    still: StillHouse, run: Run, capsys: Text, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A broker that is away, or a wrong password, looked like a house without devices."""
    monkeypatch.setattr(still, "_devices", tuple)
    assert run("devices") == 0
    assert capsys.readouterr().out == "no device discovered yet in Café; `homebot doctor` tells why\n"


def test_all_devices_of_a_large_house_are_listed_once_each(still: StillHouse, run: Run, capsys: Text) -> None:
    still.crowd = 450
    assert run("devices", "--json") == 0
    ids = [one["id"] for one in json.loads(capsys.readouterr().out)]
    assert len(ids) == len(set(ids)) == 453
    assert ids == sorted(ids)
    assert still.carried == 453


def test_a_device_that_slips_from_page_to_page_is_listed(still: StillHouse, run: Run, capsys: Text) -> None:
    still.crowd, still.restless = 450, 3
    assert run("devices", "--json") == 0
    assert len(json.loads(capsys.readouterr().out)) == 453
    assert still.carried == 453 * 2


def test_under_json_an_empty_list_comes_with_the_reason(run: Run, capsys: Text) -> None:
    assert run("find", "--json", "in", "nowhere") == 1
    out, err = capsys.readouterr()
    assert json.loads(out) == []
    assert list(json.loads(err)) == ["note"]


def test_results_are_json_on_request(run: Run, capsys: Text) -> None:
    assert run("find", "--json", "light") == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert (found["id"], found["reasons"][0], found["states"][0]["value"]) == ("kitchen-lamp", "it is number 1", True)
    assert run("show", "--json", "attic") == 0
    assert json.loads(capsys.readouterr().out)["reachable"]["why"] == "its last will says offline"


def test_a_query_that_is_not_understood_is_explained(run: Run, capsys: Text) -> None:
    assert run("find", "level >") == 1
    assert capsys.readouterr().err.startswith("homebot: ")


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("Kitchn lamp", "homebot: there is no device Kitchn lamp; did you mean Kitchen lamp"),
        ("zzzzzz", "homebot: there is no device zzzzzz; `homebot devices` lists all\n"),
    ],
)
def test_an_unknown_device_is_told_with_similar_ones(run: Run, capsys: Text, name: str, problem: str) -> None:
    assert run("show", name) == 1
    assert capsys.readouterr().err.startswith(problem)


def test_a_history_of_a_misspelt_value_names_the_right_one(run: Run, capsys: Text) -> None:
    assert run("history", "Kitchen lamp", "--capability", "powr") == 1
    assert "homebot: nothing has a value 'powr'; did you mean power" in capsys.readouterr().err
    assert run("history", "Kitchen lamp", "--capability", "power") == 1
    assert "nothing is known about that time" in capsys.readouterr().out


@pytest.mark.parametrize(("command", "code"), [("find", 0), ("history", 1)])
def test_near_matches_are_told_to_be_that(run: Run, capsys: Text, still: StillHouse, command: str, code: int) -> None:
    still.is_near = True
    assert run(command, "light") == code
    assert capsys.readouterr().err == "homebot: no device found has the word 'lihgt'; these have similar ones\n"


def test_forget_deletes_nothing_from_the_broker_unless_asked_to(still: StillHouse, run: Run, capsys: Text) -> None:
    assert run("forget", "kitchen lamp") == 0
    check("forget", capsys.readouterr().out)
    assert (still.forgotten, still.published) == (["kitchen-lamp"], [])


def test_forget_with_purge_empties_the_announcements(still: StillHouse, run: Run, capsys: Text) -> None:
    assert run("forget", "kitchen-lamp", "--purge") == 0
    check("forget_purge", capsys.readouterr().out)
    assert still.published == [("homeassistant/light/0x00158d0001abcdef/light/config", "", True)]


def test_forget_that_fails_says_why(run: Run, capsys: Text) -> None:
    assert run("forget", "attic") == 1
    assert capsys.readouterr().err == "homebot: it went a moment ago\n"


def test_split_and_merge_say_what_became_of_the_devices(run: Run, capsys: Text) -> None:
    assert run("split", "kitchen lamp", "mdns", "lamp") == 0
    assert run("merge", "attic", "kitchen lamp") == 0
    assert capsys.readouterr().out == (
        "kitchen-lamp is 2 devices now: kitchen-lamp, mdns_lamp\nattic, kitchen-lamp are one device now: kitchen-lamp\n"
    )


def test_split_and_merge_that_fail_say_why(run: Run, capsys: Text) -> None:
    assert run("split", "attic") == 1
    assert run("merge", "attic") == 1
    assert capsys.readouterr().err == (
        "homebot: a split of attic was refused: nothing was merged into it\n"
        "homebot: a merge was refused: it takes two different devices\n"
    )


def test_devices_are_written_as_thing_descriptions(run: Run, capsys: Text, tmp_path: Path) -> None:
    """One file each, named after the id, in a directory that is made."""
    directory = tmp_path / "new" / "things"
    assert run("devices", "--td", str(directory)) == 0
    files = [Path(line) for line in capsys.readouterr().out.splitlines()]
    assert [file.name for file in files] == ["attic.td.json", "kitchen_x2dlamp.td.json", "windows_x2fbath.td.json"]
    assert [read_thing(json.loads(file.read_text())).title for file in files] == ["Attic", "Kitchen lamp", "bath [31m"]
    (directory / "taken").touch()
    assert run("devices", "--td", str(directory / "taken")) == 1
    assert "taken: cannot be written: " in capsys.readouterr().err


@pytest.mark.parametrize("broker", ["http://b", "mqtt://", "mqtt://u:secret@b", "mqtt://b:x"])
def test_a_description_names_no_password(capsys: Text, broker: str) -> None:
    with pytest.raises(SystemExit):
        main(["show", "x", "--td", "--broker", broker])
    err = capsys.readouterr().err
    assert "a broker is mqtt://HOST[:PORT] or mqtts://HOST[:PORT], got" in err
    assert "secret" not in err


def description(**more: object) -> str:
    form = {"href": "mqtt://b", "mqv:topic": "lamp/on"}
    thing = {
        "@context": CONTEXT,
        "id": "urn:dev:lamp",
        "title": "Desk lamp",
        "securityDefinitions": {"nosec_sc": {"scheme": "nosec"}},
        "security": "nosec_sc",
        "properties": {"on": {"type": "boolean", "forms": [form]}},
    }
    return json.dumps(thing | more)


def test_a_thing_description_is_imported(still: StillHouse, run: Run, capsys: Text, tmp_path: Path) -> None:
    """It goes to the broker, retained, and the device that came of it is named."""
    file = tmp_path / "lamp.td.json"
    file.write_text(description())
    assert run("import", str(file)) == 0
    check("import", capsys.readouterr().out)
    ((topic, payload, retain),) = still.published
    assert (topic, json.loads(payload), retain) == ("homebot/things/urn-dev-lamp/td", json.loads(description()), True)


def test_an_import_that_makes_no_device_says_so(run: Run, capsys: Text, tmp_path: Path) -> None:
    file = tmp_path / "lamp.td.json"
    file.write_text(description())
    assert run("import", str(file), "--name", "other lamp", "--timeout", "0.1") == 1
    out = capsys.readouterr().out
    assert out.startswith("published on homebot/things/other-lamp/td, but no device appeared within 0.1 s; ")


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("{", "lamp.td.json is not JSON: Expecting property name enclosed in double quotes (line 1, column 2)"),
        ("# Lamp", "lamp.td.json is not JSON: Expecting value (line 1, column 1)"),
        ("[" * 100_000, "nested deeper than 64 levels"),
        (" " * 600_000, "is longer than 2"),
        (description(title=5), "title: expected a text, got 5"),
    ],
)
def test_a_description_that_is_none_is_refused_before_anything_is_done(
    still: StillHouse, run: Run, capsys: Text, tmp_path: Path, content: str, problem: str
) -> None:
    file = tmp_path / "lamp.td.json"
    file.write_text(content)
    assert run("import", str(file)) == 1
    err = capsys.readouterr().err
    assert err.startswith((f"homebot: {file}: ", f"homebot: {file} "))
    assert problem in err
    assert len(err) < 500
    assert run("import", str(tmp_path / "missing")) == 1
    assert "missing does not exist" in capsys.readouterr().err
    assert still.published == []


def test_topics_are_named_by_what_is_left_of_an_id() -> None:
    assert topic_level("urn:dev:ops:32473 Lamp/ä#+") == "urn-dev-ops-32473-Lamp"
    with pytest.raises(UsageError, match="give --name"):
        topic_level("///")


def test_no_command_hands_control_characters_on(run: Run, capsys: Text) -> None:
    """A device may be called what a terminal obeys."""
    for arguments in (["show", "windows/bath"], ["show", "bth"], ["devices"], ["show", "--td", "windows/bath"]):
        run(*arguments)
        printed = "".join(capsys.readouterr())
        assert printed
        assert "\x1b" not in printed


def test_purge_does_nothing_by_halves(still: StillHouse, homebot_with: object, capsys: Text) -> None:
    """A gateway that only observes deletes nothing, so nothing is forgotten either."""
    assert callable(homebot_with)
    still.acts = False
    homebot: Homebot = homebot_with(still.node, None)
    assert main(["--door", homebot.door, "forget", "kitchen-lamp", "--purge"]) == 1
    assert "publishing through mqtt was refused: the gateway only observes" in capsys.readouterr().err
    assert (still.forgotten, still.published) == ([], [])
