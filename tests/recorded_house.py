"""Devices, states and entries of the journal, as the history and the journal have them."""

from homebot.devices.command_messages import Setting
from homebot.devices.device import Device, DevicePart, Endpoint
from homebot.devices.history_messages import HistorySeries
from homebot.devices.journal_messages import EntryKind, JournalEntry, JournalVerdict
from homebot.devices.part import Capability, Part
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.value import PlainValue
from homebot.messages import Time

NOW = Time.from_seconds(0.0)
SETTABLE = {"on_off", "level", "movement", "position", "heating_setpoint", "lock"}


def part(kind: str, *names: str, part_id: str = "") -> DevicePart:
    able = tuple(
        Capability(name=one, settable=one in SETTABLE, options=("single", "double") if one == "press" else ())
        for one in names
    )
    return DevicePart(id=part_id, part=Part(id=part_id, service_type=kind, capabilities=able), routes=())


def device(name: str, *parts: DevicePart, area: str = "") -> Device:
    endpoint = Endpoint(gateway="zigbee", key=name, address="", command_address="", freshness="fresh", last_seen=NOW)
    return Device(
        id=name.lower().replace(" ", "_"),
        name=name,
        names=(name,),
        service_type=parts[0].part.service_type,
        area=area,
        endpoints=(endpoint,),
        metadata=(),
        first_seen=NOW,
        last_seen=NOW,
        expires=NOW,
        freshness="fresh",
        parts=parts,
    )


HOUSE = (
    device("Hall lamp", part("light", "on_off", "level")),
    device("Hall lamp two", part("light", "on_off"), area="hall"),
    device("Hall motion", part("occupancy_sensor", "occupancy", "battery"), area="hall"),
    device("Front door", part("contact_sensor", "contact")),
    device("Front door lock", part("door_lock", "lock")),
    device("Bath heating", part("thermostat", "heating_setpoint")),
    device("Blind", part("window_covering", "movement", "position")),
    device("Hall button", part("generic_switch", "press")),
    device("Sofa pad", part("generic_switch", "press", part_id="1"), part("generic_switch", "press", part_id="2")),
    device("Double relay", part("switch", "on_off", part_id="l"), part("switch", "on_off", part_id="r")),
    device("nobody in hall", part("light", "on_off")),
    device("wait 5m", part("light", "on_off")),
    device("notify: open the lock", part("light", "on_off")),
    device('"quoted" lamp', part("light", "on_off")),
    device("Twin", part("light", "on_off")),
    device("TWIN", part("plug", "on_off")),
    device("Anna", part("x_person", "at_home")),
    device("Household", part("x_household", "at_home")),
)


def states(device_id: str, capability: str, *changes: tuple[float, str]) -> HistorySeries:
    times, words = zip(*changes, strict=True)
    ends = (*times[1:], times[-1] + 60)
    return HistorySeries(
        device=device_id, name=device_id, part="", capability=capability, times=times, words=words, ends=ends
    )


def entry(
    kind: EntryKind,
    at: float,
    device_id: str,
    issuer: str = "",
    cause: str = "",
    command: str = "",
    trigger: Trigger = NO_TRIGGER,
    *,
    refused: bool = False,
    **values: PlainValue,
) -> JournalEntry:
    return JournalEntry(
        kind=kind,
        at=Time.from_seconds(at),
        device=device_id,
        command=command or (f"c{at}" if kind != "changed" else ""),
        issuer=issuer,
        trigger=trigger,
        settings=tuple(Setting.of(name, value) for name, value in values.items()),
        verdicts=(JournalVerdict(policy="night", allowed=False),) if refused else (),
        cause=cause,
    )
