from contextlib import suppress

import pytest
from tests.integrations.announced_parts import Say, device_in

from homebot.conventions.description import DeviceWithdrawn
from homebot.errors import WireError
from homebot.integrations.homie.formats import Homie, HomieSettings
from homebot.mqtt.topics import topic_matches

SWITCH = {"type": "hc-smarthome/v2/cap/switch", "properties": {"state": {"datatype": "boolean", "settable": True}}}
LAMP = {"homie": "5.0", "version": 1, "name": "Hall lamp", "nodes": {"switch": SWITCH}}
BASE = "homie/5/lamp-1"


def test_state_and_description_make_a_device(say: Say) -> None:
    assert say(f"{BASE}/$state", "init") == ()
    assert say(f"{BASE}/$description", LAMP) == ()
    device = device_in(say(f"{BASE}/$state", "ready"))
    assert device.key == BASE
    assert device.name == "Hall lamp"
    assert device.identifiers == ("id:homie/lamp-1",)
    assert device.topic == f"{BASE}/$state"
    assert device.implies_alive


def test_the_order_does_not_matter(say: Say) -> None:
    say(f"{BASE}/$state", "ready")
    assert device_in(say(f"{BASE}/$description", LAMP)).key == BASE


def test_doctor_hears_of_one_that_died_while_it_announced_itself(homie: Homie, say: Say) -> None:
    """Without its document it is no device, and nothing said why."""
    assert homie.problems() == ()
    say(f"{BASE}/$state", "init")
    assert homie.problems() == ()
    say(f"{BASE}/$state", "lost")
    (problem,) = homie.problems()
    assert problem.startswith(f"{BASE} is announced in part")
    say(f"{BASE}/$description", LAMP)
    assert homie.problems() == ()


def test_doctor_hears_of_a_living_one_whose_document_goes_or_becomes_illegal(homie: Homie, say: Say) -> None:
    say(f"{BASE}/$state", "ready")
    for payload in ("{", ""):
        say(f"{BASE}/$description", LAMP)
        assert homie.problems() == ()
        with suppress(WireError):
            say(f"{BASE}/$description", payload)
        assert len(homie.problems()) == 1
    say(f"{BASE}/$state", "")
    assert homie.problems() == ()


def test_doctor_hears_of_twenty_unfinished_ones_at_most(homie: Homie, say: Say) -> None:
    for number in range(30):
        say(f"{BASE}{number}/$state", "lost")
    assert len(homie.problems()) == 20


def test_a_lost_one_is_there_but_gives_no_sign_of_life(say: Say) -> None:
    say(f"{BASE}/$description", LAMP)
    assert not device_in(say(f"{BASE}/$state", "lost")).implies_alive


def test_a_repeated_document_changes_nothing(say: Say) -> None:
    say(f"{BASE}/$description", LAMP)
    say(f"{BASE}/$state", "ready")
    assert say(f"{BASE}/$description", LAMP) == ()
    assert say(f"{BASE}/$state", "sleeping") == ()
    assert say(f"{BASE}/$state", "ready") == ()


def test_a_new_description_counts_when_it_is_ready_again(say: Say) -> None:
    say(f"{BASE}/$description", LAMP)
    say(f"{BASE}/$state", "ready")
    say(f"{BASE}/$state", "init")
    assert say(f"{BASE}/$description", {**LAMP, "version": 2, "name": "Kitchen lamp"}) == ()
    assert device_in(say(f"{BASE}/$state", "ready")).name == "Kitchen lamp"


def test_an_empty_state_removes_it(say: Say) -> None:
    say(f"{BASE}/$description", LAMP)
    say(f"{BASE}/$state", "ready")
    assert say(f"{BASE}/$state", "") == (DeviceWithdrawn(BASE, "its state was removed", is_final=True),)
    assert say(f"{BASE}/$state", "") == ()


def test_an_empty_description_withdraws_it(say: Say) -> None:
    say(f"{BASE}/$description", LAMP)
    say(f"{BASE}/$state", "ready")
    assert say(f"{BASE}/$description", "") == (DeviceWithdrawn(BASE, "its description was removed"),)


def test_the_state_determines_the_availability(say: Say) -> None:
    say(f"{BASE}/$description", LAMP)
    availability = device_in(say(f"{BASE}/$state", "ready")).availability
    assert availability is not None
    (source,) = availability.sources
    words = (b"ready", b"sleeping", b"init", b"disconnected", b"lost", b"?", b"\xff")
    assert [source.read(word) for word in words] == [True, True, None, False, False, None, None]


def test_a_child_is_lost_with_its_root(say: Say) -> None:
    child = {**LAMP, "root": "bridge-1", "parent": "bridge-2"}
    say("homie/5/child-1/$description", child)
    device = device_in(say("homie/5/child-1/$state", "ready"))
    assert device.availability is not None
    assert device.availability.mode == "all"
    assert [one.topic for one in device.availability.sources] == ["homie/5/child-1/$state", "homie/5/bridge-1/$state"]
    assert device.facts["via_device"] == "bridge-2"


def test_a_bridge_that_offers_nothing_is_no_device(say: Say) -> None:
    say("homie/5/bridge-1/$description", {"homie": "5.0", "version": 1, "children": ["child-1"]})
    assert say("homie/5/bridge-1/$state", "ready") == ()


def test_one_that_offers_nothing_any_more_is_withdrawn(say: Say) -> None:
    say(f"{BASE}/$description", LAMP)
    say(f"{BASE}/$state", "ready")
    emptied = {"homie": "5.0", "version": 2}
    assert say(f"{BASE}/$description", emptied) == (DeviceWithdrawn(BASE, "it no longer has any nodes"),)


def test_a_hardware_address_at_the_end_of_the_id_is_an_identifier(say: Say) -> None:
    say("homie/5/relay-a8032abe54dc/$description", LAMP)
    device = device_in(say("homie/5/relay-a8032abe54dc/$state", "ready"))
    assert device.identifiers == ("mac:a8032abe54dc", "id:homie/relay-a8032abe54dc")


@pytest.mark.parametrize("state", ["Ready", "on", "x" * 1000])
def test_a_state_that_is_none_is_refused(homie: Homie, say: Say, state: str) -> None:
    with pytest.raises(WireError, match=r"\$state is .*, not one of init, ready, "):
        say(f"{BASE}/$state", state)
    assert homie.rejected == 1


@pytest.mark.parametrize("device_id", ["Lamp", "lamp_1", "", "lämp"])
def test_an_id_that_is_none_is_refused(say: Say, device_id: str) -> None:
    with pytest.raises(WireError, match="id"):
        say(f"homie/5/{device_id}/$state", "ready")


def test_filters_are_of_the_domains_of_the_settings() -> None:
    homie = Homie(HomieSettings(domains=("myhouse", "+")))
    assert homie.filters()[0] == "myhouse/5/+/$description"
    assert any(topic_matches(one, "other/5/lamp/$state") for one in homie.filters())
    assert not any(topic_matches(one, "myhouse/5/lamp/switch/state/set") for one in homie.filters())


def test_more_devices_than_there_is_room_for_push_out_unknown_ones(homie: Homie, say: Say) -> None:
    say(f"{BASE}/$description", LAMP)
    say(f"{BASE}/$state", "ready")
    for number in range(5000):
        say(f"homie/5/x{number}/$state", "ready")
    assert homie.reader.dropped == 1
    assert say(f"{BASE}/$state", "") != ()


def test_documents_that_wait_for_a_state_have_bounded_room(homie: Homie, say: Say) -> None:
    """Each is as long as one may be; one that is described waits no more and makes room."""
    long = {**LAMP, "nodes": {"switch": SWITCH, "n": {"properties": {}, "padding": "x" * 250_000}}}
    for number in range(70):
        say(f"homie/5/long-{number}/$description", long)
    assert homie.reader.dropped == 7
    assert say("homie/5/long-69/$state", "ready") == ()
    device_in(say("homie/5/long-0/$state", "ready"))
    say(f"{BASE}/$description", LAMP)
    device_in(say(f"{BASE}/$state", "ready"))
    say("homie/5/long-1/$description", "")
    say("homie/5/long-2/$state", "ready")
    dropped = homie.reader.dropped
    for number in (80, 81):
        say(f"homie/5/long-{number}/$description", long)
    assert homie.reader.dropped == dropped
