"""Services that explain from the journal why a device is in its state, and why it is not in another one."""

from collections.abc import Awaitable, Callable, Iterable, Iterator, Sequence
from math import inf
from typing import Final, TypeAlias, final

from homebot.control import durations
from homebot.devices import Device, KeyValue, State
from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.command_messages import Setting
from homebot.devices.device import is_commanded
from homebot.devices.journal_messages import (
    DeviceFight,
    ExplainDeviceRequest,
    ExplainDeviceResponse,
    ExplainMissingStateRequest,
    ExplainMissingStateResponse,
    Finding,
    JournalEntry,
    ReadJournalRequest,
    ReadJournalResponse,
)
from homebot.devices.outcomes import OUTCOMES, Confirmed
from homebot.devices.part import Capability, accepted_values
from homebot.devices.trigger import Trigger
from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import value_text
from homebot.errors import PeerError, ServiceError
from homebot.messages import Time

_COMMANDED_STATES: Final = {"close": "closed", "lock": "locked", "unlock": "unlocked"}
_WORDS: Final = {state: word for word, state in _COMMANDED_STATES.items()}
_FLAGS: Final = ("on", "off", "true", "false", "yes", "no")

_MAX_CHAIN: Final = 5
"""The limit of commands in a chain: the report that led to a command may be the effect of another one."""

_MAX_CHOICES: Final = 6
_REQUESTS: Final = frozenset({"requested", "published", "denied"})
_REPORTS: Final = frozenset({"reported", "changed", "reverted"})
_GOALS_END: Final = frozenset({"goal", "requested", "published"})
"""The kinds of entries the newest of which says whether the last goal still matters."""

ReadEntries: TypeAlias = Callable[[ReadJournalRequest], Awaitable[ReadJournalResponse]]

_Entries: TypeAlias = tuple[JournalEntry, ...]


@final
class _JournalReader:
    """Reader of the journal for one question.

    Attributes:
        names: The names of the devices in the entries, by id.
    """

    def __init__(self, read: ReadEntries) -> None:
        self._read = read
        self.names: dict[str, KeyValue] = {}

    async def read(
        self, *, device: str = "", command: str = "", since: float = 0.0, until: float = 0.0
    ) -> ReadJournalResponse:
        begin, end = Time.from_seconds(since), Time.from_seconds(until)
        response = await self._read(ReadJournalRequest(device=device, command=command, since=begin, until=end))
        if not response.success:
            raise PeerError(response.message)
        self.names |= {name.key: name for name in response.names}
        return response

    async def chain(self, entry: JournalEntry, deepest: int) -> _Entries:
        """Return the entries of the command of *entry*, preceded by those of the commands that led to it.

        Reports of other parts, which changed along with the command, are left out.
        """
        if not entry.command:
            return (entry,)
        known = (await self.read(command=entry.command)).entries
        own = entry.device, entry.part
        entries = tuple([step for step in known if step.kind != "reported" or (step.device, step.part) == own])
        entries = entries or (entry,)
        # A report may be older than the command that it answers: it was on its way while the command was given.
        begins = next((step for step in entries if step.kind in _REQUESTS), entries[0])
        before = await self._cause(begins) if deepest > 1 else None
        return entries if before is None else (*await self.chain(before, deepest - 1), *entries)

    async def _cause(self, command: JournalEntry) -> JournalEntry | None:
        """Return the entry of the report that triggered *command*; None if there is none."""
        trigger = command.trigger
        if not trigger.device or trigger.kind not in {"report", "message"} or not trigger.at.to_seconds():
            return None
        # The entry has the time of the report itself; earlier versions wrote that of its recording.
        response = await self.read(device=trigger.device, since=trigger.at.to_seconds(), until=command.at.to_seconds())
        reports = (entry for entry in response.entries if entry.kind in _REPORTS and entry.command != command.command)
        return next((entry for entry in reports if _is_trigger(entry, trigger)), None)


@final
class Explanations:
    """Explanations of the state of a device.

    Args:
        find_ineffective: Returns the routes of a device that are tried last, by part.
        began_at: The time before this homebot heard of any device, in seconds since the Unix epoch; inf if unknown.
    """

    def __init__(
        self,
        read: ReadEntries,
        find_device: Callable[[str], Awaitable[Device | None]],
        find_fights: Callable[[str], tuple[DeviceFight, ...]] = lambda _: (),
        find_ineffective: Callable[[Device], tuple[KeyValue, ...]] = lambda _: (),
        began_at: float = inf,
    ) -> None:
        self._read = read
        self._find_device = find_device
        self._find_fights = find_fights
        self._find_ineffective = find_ineffective
        self._began_at = began_at

    async def explain(self, request: ExplainDeviceRequest) -> ExplainDeviceResponse:
        """Return the last change of a device, with the chain of its causes."""
        try:
            return await self._explain(await self._device(request.device))
        except (PeerError, ServiceError) as exc:
            return ExplainDeviceResponse(success=False, message=str(exc))

    async def explain_missing(self, request: ExplainMissingStateRequest) -> ExplainMissingStateResponse:
        """Return the commands and the denied requests for *state* of a device."""
        try:
            device = await self._device(request.device)
            reader, wanted = _JournalReader(self._read), _as_state(request.state)
            response = await reader.read(device=device.id)
            asking = [entry for entry in response.entries if entry.kind in _REQUESTS and _asks_for(entry, wanted)]
            newest = {request.command or number: request for number, request in enumerate(asking)}
            return ExplainMissingStateResponse(
                is_so=_is_so(device, wanted),
                problem=_unknown_state(device, request.state),
                word=_command_for(device, wanted),
                entries=tuple([entry for request in newest.values() for entry in await reader.chain(request, 1)]),
                begins=response.begins,
                names=tuple(reader.names.values()),
            )
        except (PeerError, ServiceError) as exc:
            return ExplainMissingStateResponse(success=False, message=str(exc))

    async def _device(self, device_id: str) -> Device:
        device = await self._find_device(device_id)
        if device is None:
            raise PeerError(f"there is no device with the id {device_id}")
        return device

    async def _explain(self, device: Device) -> ExplainDeviceResponse:
        reader = _JournalReader(self._read)
        known = (await reader.read(device=device.id)).entries
        entries: _Entries = ()
        finding: Finding = "none"
        changed_at = Time(sec=0, nanosec=0)
        if (last := _last_change(device, known)) is not None:
            entries = await reader.chain(last, _MAX_CHAIN)
            finding, changed_at = "change" if last.kind == "changed" else "command", entries[-1].at
        elif (newest := max(_main_states(device), key=_since, default=None)) is not None:
            changed_at = newest.since
            if not newest.live:
                finding = "retained"
            elif not newest.is_first:
                finding = "change"
            else:
                finding = "heard" if device.first_seen.to_seconds() >= self._began_at else "first"
        elif (sent := next((entry for entry in reversed(known) if entry.kind == "sent"), None)) is not None:
            entries = await reader.chain(sent, 1)
        if (event := _last_event(device, changed_at)) is not None:
            finding, changed_at, entries = "event", event.at, (event,)
        names = tuple(reader.names.values())
        fights = self._find_fights(device.id)
        latest = next((entry for entry in reversed(known) if entry.kind in _GOALS_END), None)
        return ExplainDeviceResponse(
            finding=finding,
            changed_at=changed_at,
            entries=entries,
            names=names,
            fights=fights,
            ineffective=self._find_ineffective(device),
            goal=(latest,) if latest is not None and latest.kind == "goal" else (),
        )


def _last_change(device: Device, entries: Sequence[JournalEntry]) -> JournalEntry | None:
    """Return the newest entry of a change; None if the device reported newer values that the journal lacks."""
    last = next((entry for entry in reversed(entries) if _is_change(entry, entries)), None)
    if last is None:
        return None
    until = last.at.to_seconds() + durations.CAME_ALONG
    newer = [state for state in _main_states(device) if _since(state) > until]
    return last if not newer or _knows(entries, newer) else None


def _last_event(device: Device, changed_at: Time) -> JournalEntry | None:
    """Return the newest event of *device*; None if it changed since, or at the same time because of the event."""
    event = max(device.events, key=_since, default=None)
    along = durations.CAME_ALONG if _takes_commands(device) else 0.0
    if event is None or _since(event) < changed_at.to_seconds() + along:
        return None
    settings = (Setting(capability=event.capability, value=event.value),)
    return JournalEntry(kind="reported", at=event.since, device=device.id, part=event.part, settings=settings)


def _is_change(entry: JournalEntry, entries: Iterable[JournalEntry]) -> bool:
    if entry.kind in {"changed", "reverted"}:
        return True
    if entry.kind == "outcome":  # the acknowledgement is the only sign of a device that reports nothing
        return entry.results[0].outcome == Confirmed.kind
    if entry.kind != "reported":
        return False
    results = [other.results[0] for other in entries if other.command == entry.command and other.kind == "outcome"]
    is_obeyed = not results or OUTCOMES[results[0].outcome].explains_reports or bool(results[0].witness)
    return is_obeyed or bool(entry.cause)


def _knows(entries: Iterable[JournalEntry], states: Iterable[State]) -> bool:
    """Return whether *entries* contain the values of *states* and no others."""
    known = {
        (entry.part, setting.capability): setting.value.plain()
        for entry in entries
        if entry.kind in _REPORTS
        for setting in entry.settings
    }
    current = {(state.part, state.capability): state.value.plain() for state in states}
    shared = known.keys() & current.keys()
    return bool(shared) and all(known[place] == current[place] for place in shared)


def _since(state: State) -> float:
    return state.since.to_seconds()


def _main_states(device: Device) -> list[State]:
    """Return the states of the settings of *device*; of one that only reports, all."""
    main = {
        (part.id, capability.name): capability.settable
        for part in device.parts
        if not part.part.category
        for capability in part.part.capabilities
    }
    takes_commands = _takes_commands(device)
    return [state for state in device.states if main.get((state.part, state.capability)) is takes_commands]


def _takes_commands(device: Device) -> bool:
    return any(is_commanded(part.part) for part in device.parts)


def _is_trigger(entry: JournalEntry, trigger: Trigger) -> bool:
    """Return whether a report has a value of *trigger*; the values in a structured text are unknown."""
    if trigger.kind == "message":
        text = trigger.text.strip().casefold()
        return text.startswith("{") or any(
            _means(setting.capability, setting.value.plain(), text) for setting in entry.settings
        )
    values = {reading.capability: reading.value.plain() for reading in trigger.readings}
    return any(
        setting.capability in values and values[setting.capability] == setting.value.plain()
        for setting in entry.settings
    )


def _as_state(text: str) -> str:
    """Return *text* as a state, case-folded: ``close`` becomes ``closed``."""
    folded = text.strip().casefold()
    return _COMMANDED_STATES.get(folded, folded)


def _asks_for(entry: JournalEntry, wanted: str) -> bool:
    if entry.kind != "requested" and not entry.settings:  # a raw command, or one that the door refused
        word = entry.text.strip().casefold()
        return wanted in {word, _COMMANDED_STATES.get(word)}
    return any(_means(setting.capability, setting.value.plain(), wanted) for setting in entry.settings)


def _means(capability: str, value: PlainValue, wanted: str) -> bool:
    """Return whether a value is *wanted*, as ``on``, ``40``, ``40 %`` or ``level 40``: a lamp at 40 % is on."""
    match value:
        case bool():
            return wanted in (("on", "true", "yes") if value else ("off", "false", "no"))
        case str():
            return value.casefold() == wanted
        case float():
            if capability in {"level", "fan_speed"} and wanted in {"on", "off"}:
                return (value > 0) is (wanted == "on")
            if capability == "position" and wanted in {"open", "closed"}:
                return (value > 0) is (wanted == "open")
            unit = _squeeze(CAPABILITIES.get(capability, OWN).unit)
            name, number = _squeeze(capability), value_text(value)
            return _squeeze(wanted) in {number, f"{number}{unit}", f"{name}{number}", f"{name}{number}{unit}"}
    return False


def _squeeze(text: str) -> str:
    """Return *text* without the characters that differ between two spellings."""
    return text.casefold().replace(" ", "").replace("_", "")


def _is_so(device: Device, wanted: str) -> bool:
    """Return whether the last report of a main state is *wanted*."""
    states = _main_states(device)
    off = {state.part for state in states if state.capability == "on_off" and state.value.plain() is False}
    return any(
        _means(state.capability, state.value.plain(), wanted)
        for state in states
        if state.capability == "on_off" or state.part not in off  # a lamp that is off is not at its level
    )


def _unknown_state(device: Device, state: str) -> str:
    """Return a sentence that explains why no command can bring *device* to *state*; empty if one may."""
    settable = [
        (part.part, capability.name)
        for part in device.parts
        for capability in part.part.capabilities
        if capability.settable
    ]
    if not device.parts:
        return ""
    if not settable:
        return "It takes no commands; it only reports."
    if any(_may_be(capability, _as_state(state)) for capability in _capabilities(device)):
        return ""
    known = "; ".join(f"{name} {accepted_values(part, name)}" for part, name in settable[:_MAX_CHOICES])
    more = "; …" if len(settable) > _MAX_CHOICES else ""
    return f"It has no state {state[:40]!r}. It takes {known}{more}."


def _command_for(device: Device, wanted: str) -> str:
    """Return the word that commands *wanted*; empty if the command needs more than one word."""
    if wanted in _WORDS:
        return _WORDS[wanted]
    options = {option.casefold() for can in _capabilities(device) if can.settable for option in can.options}
    return wanted if wanted in {"on", "off", "open", *options} and " " not in wanted else ""


def _capabilities(device: Device) -> Iterator[Capability]:
    return (capability for part in device.parts for capability in part.part.capabilities)


def _may_be(capability: Capability, wanted: str) -> bool:
    known = CAPABILITIES.get(capability.name, OWN)
    options = {option.casefold() for option in capability.options or known.options}
    if not known.kind:
        return True
    if known.kind == "bool":
        return wanted in _FLAGS
    if options:
        return wanted in options or _WORDS.get(wanted) in options
    return known.kind == "text" or any(char.isdigit() for char in wanted) or wanted in {"on", "off", "open", "closed"}
