"""What comes on the topics of offers: commands to what was offered, of its kind and in its bounds, or nothing."""

import json

from tests.fuzz.conftest import Fuzz, check_value

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.exposure import ExposedDevice
from homebot.devices.part import Capability, Part
from homebot.integrations.homeassistant.formats.publisher import HomeAssistantPublisher

ORDERS = (
    '{"state":"ON","brightness":102,"color":{"h":300,"s":50},"color_temp":250,"effect":"x","transition":2}',
    '{"state":"OFF"}',
    '{"state":"ON","tone":"a","volume_level":0.5}',
    *"ON OFF PRESS LOCK UNLOCK OPEN 50 1e3 start oscillate_on heat DISARM jammed".split(),  # noqa: SIM905
)


def test_any_order_is_commands_of_their_kinds(fuzz: Fuzz) -> None:
    for mutate, rng in fuzz("offers", ORDERS):
        names = rng.sample(sorted(CAPABILITIES), 4) + rng.sample(["on_off", "level", "color", "lock", "position"], 2)
        offered = {
            name: Capability(name=name, settable=rng.random() < 0.8, options=rng.choice(((), ("a", "b"))))
            for name in names
        }
        part = Part(id="p", service_type=rng.choice(sorted(DEVICE_TYPES)), capabilities=tuple(offered.values()))
        ours = HomeAssistantPublisher("homeassistant", "hub", "s")
        configs = ours.publications(ExposedDevice(id="o", name=mutate.word().replace("\ud800", ""), parts=(part,)))
        for config in configs:
            fields = json.loads(config.payload)
            for topic in {text for key, text in fields.items() if key.endswith("command_topic")}:
                order = mutate.damaged_json(rng.choice(ORDERS)) if rng.random() < 0.7 else rng.choice(ORDERS).encode()
                for command in ours.read_command(topic, order):
                    value = command.value.plain()
                    assert offered[command.capability].settable
                    check_value(command.capability, value)
                    assert command.capability != "lock" or value in {"locked", "unlocked", "open"}
