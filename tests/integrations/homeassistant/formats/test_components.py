"""Components of configs: their parts, states, commands and refusals.

``components.jsonl`` has a config per line:

- ``part``: its description; ``r`` marks a readable capability, ``w`` a settable one, ``e`` an echo;
- ``refused``: the reason why the config is refused, as Home Assistant refuses it;
- ``tests``: by name, steps on a new part: ``read`` a payload on a topic, which ``is`` these values, or ``write`` a
  value, perhaps with a ``code`` or a ``transition``, which ``publishes`` messages or is ``refused``.
"""

import json
from collections.abc import Mapping
from contextlib import suppress
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from homebot.conventions.description import DescribedPart, Publication, TakesCode
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.integrations.homeassistant.formats.components import BUILDERS
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.reader import PartShapes, builder_of

LINES = [json.loads(line) for line in Path(__file__).with_name("components.jsonl").read_text().splitlines()]


def name(line: Mapping[str, Any]) -> str:
    return f"{line['component']}-{LINES.index(dict(line)) + 1}"


def build(line: Mapping[str, Any]) -> DescribedPart:
    config = DiscoveryConfig(line["component"], line.get("id", "node_1"), line["config"])
    return builder_of(line["component"])(config)


def build_both(line: Mapping[str, Any]) -> list[DescribedPart]:
    """Build the part of another device, which has other names and topics alone, and then the part."""
    shapes = PartShapes()
    own = {key: f"other/{value}" for key, value in line["config"].items() if key.endswith("topic") and value}
    both = ({**line["config"], **own, "name": "Other", "unique_id": "other"}, line["config"])
    configs = [DiscoveryConfig(line["component"], line.get("id", "node_1"), fields) for fields in both]
    return [shapes.part(config, builder_of(line["component"])) for config in configs]


def build_second(line: Mapping[str, Any]) -> DescribedPart:
    return build_both(line)[1]


def shape(described: DescribedPart) -> dict[str, Any]:
    """Return the description in the form of the table."""
    part = described.part
    capabilities = {}
    for one in part.capabilities:
        flags = "".join(
            flag for flag, is_set in zip("rwe", (one.readable, one.settable, one.echoed), strict=True) if is_set
        )
        further = {key: value for key in ("unit", "bounds", "options") if (value := getattr(one, key))}
        capabilities[one.name] = [flags, further] if further else [flags]
    topics = described.codec.topics()
    found: dict[str, object] = {
        "id": part.id,
        "name": part.name,
        "type": part.service_type,
        "tag": part.tag,
        "category": part.category,
        "capabilities": capabilities,
        "reads": topics,
        "writes": part.writes,
        "expiries": described.expiries,
        "pictures": part.reads if part.reads != topics else (),
    }
    return {key: value for key, value in found.items() if value or key not in OPTIONAL}


OPTIONAL = {"tag", "category", "pictures", "expiries"}


@pytest.mark.parametrize("line", [line for line in LINES if "part" in line], ids=name)
def test_a_config_is_described_and_its_states_are_read_and_commands_are_written(line: Mapping[str, Any]) -> None:
    for made in (build, build_second):
        assert json.loads(json.dumps(shape(made(line)))) == line["part"]
        for sentence, steps in line["tests"].items():
            part = made(line)
            for step in steps:
                check_step(part, step, f"{sentence}: {step}")


def test_every_component_has_its_line() -> None:
    assert {line["component"] for line in LINES if "part" in line} == set(BUILDERS)


@pytest.mark.parametrize("line", [line for line in LINES if "refused" in line], ids=name)
def test_an_invalid_config_is_refused_with_the_reason(line: Mapping[str, Any]) -> None:
    with pytest.raises(WireError) as refused:
        build(line)
    assert str(refused.value) == line["refused"]


def write(part: DescribedPart, step: Mapping[str, Any]) -> tuple[Publication, ...]:
    capability, value = step["write"]
    wanted: PlainValue = tuple(value) if isinstance(value, list) else value
    if "code" not in step:
        return part.codec.write(capability, wanted, transition=step.get("transition", 0.0))
    assert isinstance(part.codec, TakesCode)
    return part.codec.write_with_code(capability, wanted, step["code"])


def check_step(part: DescribedPart, step: Mapping[str, Any], told: str) -> None:
    if "read" in step:
        topic, payload = step["read"]
        found = part.codec.read(topic, payload.encode("latin-1"), retained=step.get("retained", False))
        assert json.loads(json.dumps(dict(found))) == step["is"], told
    elif "refused" in step:
        with pytest.raises(RefusedError) as refused:
            write(part, step)
        assert str(refused.value) == step["refused"], told
        assert not step.get("code") or step["code"] not in str(refused.value), told
    else:
        published = tuple(Publication(topic, text.encode("latin-1"), *how) for topic, text, *how in step["publishes"])
        assert write(part, step) == published, told


def test_a_part_is_built_once_for_all_devices_that_have_it() -> None:
    built: list[str] = []

    def build_and_count(config: DiscoveryConfig) -> DescribedPart:
        built.append(config.part_id)
        return builder_of("sensor")(config)

    shapes = PartShapes()
    for number in range(3):
        fields = {"unique_id": f"{number}", "name": f"Battery {number}", "state_topic": f"s/{number}", "~": 1}
        part = shapes.part(DiscoveryConfig("sensor", "", {**fields, "device_class": "battery"}), build_and_count)
        assert (part.part.id, part.part.name, part.part.reads) == (f"{number}", f"Battery {number}", (f"s/{number}",))
        assert part.codec.read(f"s/{number}", b"7", retained=False) == {"battery": 7.0}
    assert built == ["0"]


def test_equal_parts_differ_if_their_topics_are_equal_or_not() -> None:
    """A state on the command topic may only repeat the command."""
    shapes = PartShapes()
    for states, commands, is_echoed in (("a", "b", False), ("c", "c", True), ("d", "e", False)):
        config = DiscoveryConfig("switch", "", {"state_topic": states, "command_topic": commands})
        (capability,) = shapes.part(config, builder_of("switch")).part.capabilities
        assert capability.echoed is is_echoed


@pytest.mark.parametrize("line", [line for line in LINES if "part" in line], ids=name)
def test_equal_parts_remember_only_their_own_messages_and_commands(line: Mapping[str, Any]) -> None:
    """Lamps, climates and covers remember some: one of three channels is dimmed by its last colour."""
    for (others, theirs), (sentence, steps) in product(line["tests"].items(), repeat=2):
        other, part = build_both(line)
        for step in steps:
            for one in theirs:
                say_or_take(other, one)
            check_step(part, step, f"{sentence}, while of another one {others}: {step}")


def say_or_take(other: DescribedPart, step: Mapping[str, Any]) -> None:
    if "read" in step:
        topic, payload = step["read"]
        other.codec.read(f"other/{topic}", payload.encode("latin-1"), retained=step.get("retained", False))
    else:
        with suppress(RefusedError):
            write(other, step)


def test_a_template_that_fails_with_a_code_does_not_show_it() -> None:
    config = {"command_topic": "alarm/set", "state_topic": "alarm", "command_template": "{{ code + 1 }}"}
    part = build({"component": "alarm_control_panel", "config": config})
    with pytest.raises(RefusedError) as refused:
        write(part, {"write": ["alarm", "disarmed"], "code": "73550173"})
    assert "73550173" not in f"{refused.value} {refused.value.__cause__} {refused.value.__context__}"


def test_the_code_of_an_alarm_is_in_no_description() -> None:
    config = {"command_topic": "alarm/set", "state_topic": "alarm", "code": "1234"}
    assert "1234" not in str(build({"component": "alarm_control_panel", "config": config}).part)
