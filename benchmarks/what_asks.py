"""What asks whom: the parts of every model of Zigbee2MQTT, and names in fifteen languages, by the two rules.

The npm package zigbee2mqtt makes the announcements, see ``zigbee_house.js``; ``make bench`` installs it. To see which
models are behind a row: ``python what_asks.py DIRECTORY``, where the package is installed.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from homebot.conventions.description import DeviceAnnounced
from homebot.devices import Device, DevicePart, Endpoint, KeyValue, Route
from homebot.devices.always_ask import models_of, why_it_asks
from homebot.devices.harmless import why_not_harmless
from homebot.devices.part import Capability, Part
from homebot.integrations.zigbee2mqtt.formats.reader import Zigbee2MqttReader
from homebot.messages import Time
from plan import Plan
from report import Report

__all__ = ["run"]

HERE = Path(__file__).parent
PACKAGES = HERE.parent / ".venv-bench-zigbee"
NAMES = HERE.parent / "tests/devices/loads_by_name.json"
TITLE = "what_asks: parts that take commands, by who may command them without a right that names them"
HEADINGS = ("parts", "total", "everybody (`act: harmless`)", "the owner's apps (`act: ordinary`)", "nobody: always ask")
EACH_QUICK = 20
NOW = Time(sec=0, nanosec=0)
KINDS = (
    ("light", "on_off"),
    ("plug", "on_off"),
    ("switch", "on_off"),
    ("window_covering", "movement"),
    ("x_setting", "push"),
)


def run(plan: Plan) -> Report:
    parts = [*_of_names()]
    missing = []
    if shutil.which("node") is None or not (PACKAGES / "node_modules").exists():
        missing.append("the models, as Node.js or the npm package zigbee2mqtt is not installed")
    else:
        parts += _of_models(PACKAGES, EACH_QUICK if plan.quick else 1)
    return Report(TITLE, [], [], [HEADINGS, *_rows(parts)], missing)


def _rows(parts: Iterable[tuple[str, Device, DevicePart]]) -> Iterator[tuple[str, ...]]:
    counts: dict[str, Counter[str]] = {}
    for title, device, part in parts:
        counts.setdefault(title, Counter())[_scope(device, part)] += 1
    for title, count in sorted(counts.items()):
        yield title, *(f"{number:,}" for number in (count.total(), count["harmless"], count["ordinary"], count["asks"]))


def _scope(device: Device, part: DevicePart) -> str:
    """Return the least right that is enough for *part*."""
    if why_it_asks(device, part):
        return "asks"
    return "ordinary" if why_not_harmless(device, part) else "harmless"


def _of_models(directory: Path, each: int) -> Iterator[tuple[str, Device, DevicePart]]:
    """Yield the parts of devices of Zigbee2MQTT that nobody gave a name."""
    command = ["node", str(HERE / "zigbee_house.js"), str(directory), str(each)]
    made = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout.splitlines()
    reader = Zigbee2MqttReader(("zigbee2mqtt",))
    for topic, payload in map(json.loads, made):
        if topic != "zigbee2mqtt/bridge/devices":
            continue
        for told in reader.read_message(topic, payload.encode(), retained=True):
            assert isinstance(told, DeviceAnnounced)
            device = _device(told.key, [one.part for one in told.parts], told.facts)
            for part in device.parts:
                if any(one.settable for one in part.part.capabilities):
                    yield f"models: {part.part.service_type}", device, part


def _of_names() -> Iterator[tuple[str, Device, DevicePart]]:
    """Yield a lamp, a plug, a relay, a cover of unknown class and a button of each name."""
    for lists in json.loads(NAMES.read_text(encoding="utf-8")).values():
        for name in (*lists["asks"], *lists["free"]):
            title = "names of gates, valves, boilers, …" if name in lists["asks"] else "names of lamps, blinds, fans, …"
            for service_type, capability in KINDS:
                can = Capability(name=capability, settable=True)
                device = _device("0x1", [Part(id="", name=name, service_type=service_type, capabilities=(can,))], {})
                yield f"{title}: {service_type}", device, device.parts[0]


def _device(key: str, parts: Sequence[Part], facts: Mapping[str, str]) -> Device:
    route = Route(gateway="mqtt", key=key, part="")
    return Device(
        id=key,
        name=key,
        service_type="",
        endpoints=(Endpoint(gateway="mqtt", key=key, address="", command_address=""),),
        metadata=tuple(KeyValue(key=name, value=value) for name, value in facts.items()),
        first_seen=NOW,
        last_seen=NOW,
        expires=NOW,
        freshness="fresh",
        parts=tuple(DevicePart(id=one.id, part=one, routes=(route,)) for one in parts),
    )


def _print_models(directory: Path) -> None:
    found: dict[tuple[str, str], set[str]] = {}
    for title, device, part in _of_models(directory, 1):
        reason = why_it_asks(device, part) or why_not_harmless(device, part) or "harmless"
        model = next(iter(models_of(device)), "")
        found.setdefault((title, _scope(device, part)), set()).add(f"{model} {part.id} ({reason})")
    for (title, scope), models in sorted(found.items()):
        print(f"## {title}, {scope}", *sorted(models), sep="\n  ")


if __name__ == "__main__":
    _print_models(Path(sys.argv[1]))
