"""Configs and states published for a Home Assistant, read back by the convention."""

import json

import pytest
from tests.integrations.announced_parts import announced

from homebot.conventions.description import DeviceWithdrawn
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.exposure import ExposedDevice
from homebot.devices.part import Capability, Part
from homebot.integrations.homeassistant.formats import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.integrations.homeassistant.formats.publisher import HomeAssistantPublisher

STATUS = "homebot/hub/mqtt/status"


def publisher() -> HomeAssistantPublisher:
    made = HomeAssistantDiscovery(HomeAssistantSettings(publish=True)).publisher("hub/mqtt", STATUS)
    assert made is not None
    return made


def offer(*capabilities: Capability, name: str = "Robot", **fields: object) -> ExposedDevice:
    part = Part(id="robot", service_type="x_robot", capabilities=capabilities)
    return ExposedDevice.model_validate({"id": "robot1", "name": name, "parts": (part,), **fields})


def test_nothing_is_published_unless_it_is_wanted() -> None:
    assert HomeAssistantDiscovery(HomeAssistantSettings()).publisher("hub", STATUS) is None


def test_a_config_fits_the_schema_of_home_assistant() -> None:
    (config,) = publisher().publications(offer(Capability(name="on_off", settable=True), model="Rover", area="hall"))
    assert config.topic.startswith("homeassistant/switch/homebot_hub_mqtt_")
    assert (config.retain, config.qos) == (True, 1)
    fields = json.loads(config.payload)
    assert fields["device"]["name"] == "Robot"
    assert (fields["device"]["model"], fields["device"]["suggested_area"]) == ("Rover", "hall")
    assert fields["origin"] == {"name": "homebot"}
    assert fields["availability_topic"] == STATUS
    assert fields["command_topic"] == fields["state_topic"].removesuffix("/state") + "/set"


def test_every_capability_of_the_vocabulary_can_be_offered() -> None:
    for name, known in CAPABILITIES.items():
        for settable in (True, False):
            configs = publisher().publications(offer(Capability(name=name, settable=settable)))
            is_unseen = known.kind == "numbers" or (name in {"push", "scene", "locate"} and not settable)
            assert len(configs) == (not is_unseen)
            heard = [(config.topic, config.payload.decode()) for config in configs]
            assert len(announced(HomeAssistantDiscovery(HomeAssistantSettings()), *heard)) == len(configs)


def test_a_withdrawn_part_is_removed_and_takes_no_command() -> None:
    ours = publisher()
    offered = offer(Capability(name="on_off", settable=True))
    (config,) = ours.publications(offered)
    command_topic = json.loads(config.payload)["command_topic"]
    gone, state = ours.publications(offered.model_copy(update={"is_withdrawn": True}))
    assert (gone.topic, gone.payload, gone.retain) == (config.topic, b"", True)
    assert (state.topic, state.payload, state.retain) == (json.loads(config.payload)["state_topic"], b"", True)
    assert ours.read_command(command_topic, b"ON") == ()
    (heard,) = HomeAssistantDiscovery(HomeAssistantSettings()).read_message(gone.topic, b"", retained=False)
    assert isinstance(heard, DeviceWithdrawn)


@pytest.mark.parametrize(
    ("capability", "payload"),
    [
        *(("on_off", payload) for payload in (b"", b"on", b"\xff", b"x" * 2000, b"1")),
        *(("level", payload) for payload in (b"nan", b"101", b"-1", b"1e999", b"much")),
    ],
)
def test_a_command_that_is_invalid_or_out_of_bounds_is_ignored(capability: str, payload: bytes) -> None:
    ours = publisher()
    (config,) = ours.publications(offer(Capability(name=capability, settable=True)))
    assert ours.read_command(json.loads(config.payload)["command_topic"], payload) == ()


def test_names_and_ids_of_any_kind_stay_apart() -> None:
    ours = publisher()
    capability = Capability(name="on_off", settable=True)
    ids = ("küche", "kuche", "a/b", "a b", "+", "#", "x" * 50)
    topics = {ours.publications(offer(capability, id=one, name="+/#\0"))[0].topic for one in ids}
    assert len(topics) == len(ids)
    for topic in topics:
        assert ours.is_own_topic(topic)
        assert not set(topic) & set("+#\0 ")
    assert not ours.is_own_topic("homeassistant/switch/other/config")
