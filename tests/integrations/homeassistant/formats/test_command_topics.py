"""A topic of commands is read by its own device alone.

Its devices are those of ``homebot.integrations.homeassistant``.
"""

import json
from typing import Any

import pytest

from homebot.conventions.convention import Convention
from homebot.conventions.description import DeviceAnnounced
from homebot.conventions.installed_conventions import find_conventions
from homebot.devices.part import CommandDescription
from homebot.gateways.mqtt.registry import AnnouncementRegistry, TopicReaders
from homebot.gateways.mqtt.state_topics import StateTopics

(CONVENTION,) = find_conventions(("homeassistant",), {}, "")


def announced(
    registry: AnnouncementRegistry,
    component: str,
    name: str,
    device: str = "",
    *,
    is_retained: bool = False,
    **config: Any,
) -> None:
    fields = {"unique_id": name, **config}
    if device:
        fields["device"] = {"identifiers": [device], "name": device}
    topic = f"homeassistant/{component}/{name}/config"
    (described,) = CONVENTION.read_message(topic, json.dumps(fields).encode(), retained=True)
    assert isinstance(described, DeviceAnnounced)
    registry.put(described, is_retained=is_retained)


def registry_of(*conventions: Convention) -> AnnouncementRegistry:
    return AnnouncementRegistry("mqtt", conventions, StateTopics(()))


def readers_of(registry: AnnouncementRegistry, topic: str) -> list[str]:
    route = registry.route(topic) or TopicReaders(())
    parts = [one.stored.key for one in route.announced_parts]
    return parts + [stored.key for one in route.availability_readers for stored, _ in one.reachability.members]


def test_a_switch_that_reports_where_it_is_told_is_read_with_its_device_and_no_other_is() -> None:
    registry = registry_of(CONVENTION)
    announced(registry, "switch", "plug", "plug17", state_topic="desk/plug", command_topic="desk/plug")
    announced(registry, "sensor", "own", "plug17", state_topic="desk/plug")
    announced(registry, "sensor", "other", "other17", state_topic="desk/plug")
    announced(registry, "sensor", "nobody", state_topic="desk/+")
    assert readers_of(registry, "desk/plug") == ["homeassistant:switch/plug", "homeassistant:sensor/own"]
    announced(registry, "switch", "plug", "plug17", state_topic="desk/plug", command_topic="desk/set")
    assert len(readers_of(registry, "desk/plug")) == 4
    assert readers_of(registry, "desk/set") == []


def test_nobody_learns_from_what_an_alarm_is_told_that_another_device_is_there() -> None:
    """A template would tell the digits of a code, one after the other."""
    registry = registry_of(CONVENTION)
    announced(registry, "sensor", "spy", state_topic="spy", availability_topic="alarm/set")
    assert readers_of(registry, "alarm/set") == ["homeassistant:sensor/spy"]
    announced(registry, "alarm_control_panel", "alarm", state_topic="alarm", command_topic="alarm/set")
    assert readers_of(registry, "alarm/set") == []
    registry.remove("homeassistant:alarm_control_panel/alarm")
    assert readers_of(registry, "alarm/set") == ["homeassistant:sensor/spy"]


def approve(registry: AnnouncementRegistry, key: str) -> None:
    template = registry.by_key[key].template
    registry.set_approved([CommandDescription.of(part, template.identifiers).digest for part in template.parts])


@pytest.mark.parametrize("is_retained", [True, False])
@pytest.mark.parametrize("kind", ["alarm_control_panel", "switch"])
def test_a_stranger_that_takes_commands_on_the_state_of_a_plug_does_not_hide_it(
    *, kind: str, is_retained: bool
) -> None:
    """One retained message each would silence a house, also after a restart, when nobody knows who was first."""
    registry = registry_of(CONVENTION)
    topics = {"state_topic": "z/plug", "command_topic": "z/plug/set"}
    stranger = {"state_topic": "z/x", "command_topic": "z/plug"}
    order = [("switch", "plug", "plug17", topics), (kind, "evil", "evil17", stranger)]
    for component, name, device, config in order[::-1] if is_retained else order:
        announced(registry, component, name, device, is_retained=is_retained, **config)
    assert readers_of(registry, "z/plug") == ["homeassistant:switch/plug"]


def test_nobody_reads_the_command_topic_of_an_approved_alarm() -> None:
    registry = registry_of(CONVENTION)
    announced(registry, "sensor", "spy", state_topic="home/alarm")
    announced(registry, "alarm_control_panel", "alarm", state_topic="a", command_topic="home/alarm")
    announced(registry, "sensor", "late", state_topic="home/alarm")
    assert readers_of(registry, "home/alarm") == ["homeassistant:sensor/spy"]
    approve(registry, "homeassistant:alarm_control_panel/alarm")
    assert readers_of(registry, "home/alarm") == []


def test_after_a_restart_a_spy_that_is_read_first_learns_nothing_from_an_alarm() -> None:
    registry = registry_of(CONVENTION)
    announced(registry, "sensor", "spy", is_retained=True, state_topic="alarm/set")
    announced(registry, "alarm_control_panel", "alarm", is_retained=True, state_topic="a", command_topic="alarm/set")
    assert readers_of(registry, "alarm/set") == []


def test_who_changes_its_topics_is_a_newcomer_there() -> None:
    registry = registry_of(CONVENTION)
    announced(registry, "sensor", "spy", state_topic="spy")
    announced(registry, "alarm_control_panel", "alarm", state_topic="a", command_topic="home/alarm")
    announced(registry, "sensor", "spy", state_topic="home/alarm")
    assert readers_of(registry, "home/alarm") == []


def test_however_many_others_take_commands_on_a_topic_the_first_device_is_read_and_they_are_not() -> None:
    """A stranger would hide the state of a plug that is told and reports on one topic."""
    registry = registry_of(CONVENTION)
    announced(registry, "switch", "plug", "plug17", state_topic="desk/plug", command_topic="desk/plug")
    for number in range(257):
        announced(registry, "switch", f"s{number}", state_topic="desk/plug", command_topic="desk/plug")
    assert readers_of(registry, "desk/plug") == ["homeassistant:switch/plug"]
    announced(registry, "switch", "plug", "plug17", state_topic="desk/plug", command_topic="desk/plug", retain=True)
    assert readers_of(registry, "desk/plug") == ["homeassistant:switch/plug"]
    registry.remove("homeassistant:switch/plug")
    assert readers_of(registry, "desk/plug") == ["homeassistant:switch/s0"]


def test_of_too_many_on_a_topic_where_they_take_commands_the_first_are_read() -> None:
    """Or each of their messages would be a second of work."""
    registry = registry_of(CONVENTION)
    for number in range(257):
        announced(registry, "switch", f"s{number}", "flood17", state_topic="s", command_topic="s")
    assert readers_of(registry, "s") == [f"homeassistant:switch/s{number}" for number in range(256)]
    registry.remove("homeassistant:switch/s0")
    assert len(readers_of(registry, "s")) == 256


@pytest.mark.parametrize("topic", ["z/door/set", "z/door/set/pin_code", "z/door/set/#"])
def test_nobody_reads_what_other_clients_tell_a_lock_even_if_homebot_sends_it_no_code(topic: str) -> None:
    """Zigbee2MQTT takes ``pin_code`` so."""
    registry = registry_of(CONVENTION)
    announced(registry, "switch", "spy", state_topic=topic, command_topic="z/door/set")
    assert readers_of(registry, topic.replace("#", "pin_code")) == ["homeassistant:switch/spy"]
    announced(registry, "lock", "door", "door17", state_topic="z/door", command_topic="z/door/set")
    assert readers_of(registry, topic.replace("#", "pin_code")) == []
    assert readers_of(registry, "z/door") == ["homeassistant:lock/door"]
