"""Journal entries, and explanations of a device, in words. Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from datetime import UTC, datetime
from typing import TYPE_CHECKING, TypeAlias

from homebot.devices.outcomes import cause_text, has_succeeded
from homebot.devices.wording.time_format import ago, to_seconds
from homebot.devices.wording.values import plain_value, value_text
from homebot.feature import cause_words
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.command_messages import Setting
    from homebot.devices.journal_messages import ExplainDeviceResponse, JournalEntry
    from homebot.devices.trigger import Trigger
    from homebot.devices.value import Reading
    from homebot.messages import Time

Chain: TypeAlias = "list[JournalEntry]"
"""The entries of a command, oldest first, or the single entry of a change."""

_MAX_WAIT_S = 900.0
"""Seconds after which a command has an outcome, unless it has a very long transition."""

_UNEXPLAINED = "no command explains it: somebody did it by hand, or it did so by itself"

_BY_ITSELF = "it did so by itself, as usual"

_BY_PROGRAM = "another program did it past homebot, as usual"

_REASONS = {"device": _BY_ITSELF, "program": _BY_PROGRAM}
"""Reasons of changes by their cause in the journal."""

_FINDINGS = {
    "command": "It changed {ago}: {reason}.",
    "change": "It changed {ago}: {reason}.",
    "event": "It reported {reason} {ago}.",
    "heard": "It has been so since homebot first heard of it, {ago}.",
    "retained": "It was so already {ago}; the age of a retained value is unknown.",
    "first": "It was so already {ago}, when it first reported its state.",
}

_CLIENT = "client:"
_REQUESTS: Mapping[str, str] = {
    "advertise": "to announce that it publishes on",
    "advertise_service": "to provide",
    "call_service": "to call",
    "subscribe": "to subscribe to",
}


def entry_text(entry: JournalEntry, names: Mapping[str, str]) -> str:
    """Return one entry as a clause, with the name of the device if it is about the device."""
    text = _entry_text(entry, names)
    return f"{text}, and {entry.folded:,} more times in the minute before" if entry.folded else text


def caused_text(entry: JournalEntry, names: Mapping[str, str]) -> str:
    """Return *entry* as a clause, with its cause."""
    cause = trigger_text(entry.trigger, names)
    return entry_text(entry, names) + (f", because {cause}" if cause else "")


def _entry_text(entry: JournalEntry, names: Mapping[str, str]) -> str:
    text = _TEXTS.get(entry.kind)
    return printable(entry.results[0].text) if text is None else text(entry, name_text(entry.device, names, entry.part))


def repeats(entry: JournalEntry, before: JournalEntry | None) -> bool:
    """Return whether *entry*, the outcome of a refused command, only repeats the verdict *before* it."""
    if before is None or (before.kind, entry.kind) != ("judged", "outcome"):
        return False
    result, verdict = entry.results[0], before.verdicts[0]
    return (entry.command, result.policy) == (before.command, verdict.policy) and not verdict.allowed


def denial_text(entry: JournalEntry) -> str:
    """Return why, and how often, a request was denied, without the advice to the client."""
    reason = printable(entry.verdicts[0].reason.partition("; ")[0])
    times = _facts(entry).get("count", 1)
    return f"{reason} ({times:,.0f} times)" if isinstance(times, float) and times > 1 else reason


def trigger_text(trigger: Trigger, names: Mapping[str, str]) -> str:
    """Return the cause of a command as a clause; empty if unknown."""
    cause = _cause_text(trigger, names)
    if not trigger.scene:
        return cause
    done = "undone" if trigger.is_undo else "applied"
    return f"the scene {printable(trigger.scene, 100)} was {done}{f' when {cause}' if cause else ''}"


def _cause_text(trigger: Trigger, names: Mapping[str, str]) -> str:
    name = name_text(trigger.device, names, next((reading.part for reading in trigger.readings), ""))
    match trigger.kind:
        case "lease":
            return f"{printable(trigger.text, 200)} holds it"
        case "report":
            return f"{name} reported {settings_text(trigger.readings)}"
        case "message":
            return f"{name} sent {printable(trigger.text, 60)!r}"
        case "device":
            return f"{name} {printable(trigger.text, 100)}"
        case "end":
            return f"{printable(trigger.text, 200)}, and it is put back"
        case "client":
            issuer, _, rest = trigger.text.partition(" ")
            return f"{issuer_text(issuer)} {printable(rest, 100)}"
        case "timer":
            return f"its timer ({printable(trigger.text)}) was due"
    return cause_words(trigger.kind).format(text=printable(trigger.text, 200)) if trigger.kind else ""


def settings_text(settings: Iterable[Setting | Reading]) -> str:
    """Return values in words: ``on``, ``level 40 %``."""
    return ", ".join(_setting_text(setting) for setting in settings) or "nothing"


def issuer_text(issuer: str) -> str:
    """Return the issuer of a command: the name of an app, or "the client NAME"."""
    if issuer.startswith(_CLIENT):
        return f"the client {printable(issuer.removeprefix(_CLIENT), 60)}"
    return printable(issuer.removeprefix("/"), 60) or "somebody"


def name_text(device: str, names: Mapping[str, str], part: str = "") -> str:
    """Return the name of a device, or of its *part* if *names* has ``ID#PART``; without a name, the id."""
    return printable(names.get(f"{device}#{part}") or names.get(device) or device, 60)


def ago_text(time: Time, now: float) -> str:
    """Return a time as ``4 min ago, at 10:03:12`` or ``just now, at 10:03:12``."""
    return f"{ago(time, now).replace('now', 'just now')}, at {clock_text(time, now).rpartition('.')[0]}"


def clock_text(time: Time, now: float) -> str:
    """Return a local time of day to a tenth of a second, with the date unless it is today."""
    seconds = to_seconds(time)
    local = datetime.fromtimestamp(seconds, UTC).astimezone()
    today = datetime.fromtimestamp(now, UTC).astimezone().date()
    text = f"{local:%H:%M:%S}.{local.microsecond // 100_000}"
    return text if local.date() == today else f"{local:%Y-%m-%d} {text}"


def _verdict_text(entry: JournalEntry, _name: str) -> str:
    verdict = entry.verdicts[0]
    reason = f": {printable(verdict.reason)}" if verdict.reason else ""
    return f"{printable(verdict.policy)} {'allowed it' if verdict.allowed else 'refused it'}{reason}"


def _ended_text(entry: JournalEntry, name: str) -> str:
    return f"{issuer_text(entry.issuer)} ended the lease by which {printable(entry.text, 60)} held {name}"


def _holder(entry: JournalEntry) -> str:
    return f"{printable(entry.text, 60)} ({issuer_text(entry.issuer)})"


def _wanted(entry: JournalEntry) -> str:
    return settings_text(entry.settings)


def _way(text: str) -> str:
    """Return how a command was sent: ``again``, or ``group NAME``, with others in one message."""
    if text in {"", "again"}:
        return f" {text}".rstrip()
    return f" in one message to the {printable(text, 100)}"


_TEXTS: Mapping[str, Callable[[JournalEntry, str], str]] = {
    "requested": lambda entry, name: f"{issuer_text(entry.issuer)} asked {name} for {_wanted(entry)}",
    "would": lambda _entry, _: "not sent: this is a dry run",
    "published": lambda entry, name: f"{issuer_text(entry.issuer)} published {printable(entry.text)!r} for {name}",
    "judged": _verdict_text,
    "sent": lambda entry, _: f"handed to the gateway{_way(entry.text)}",
    "acknowledged": lambda entry, _: f"{printable(entry.text) or 'the network'} accepted it",
    "reported": lambda entry, name: f"{name} reported {_wanted(entry)}",
    "denied": lambda entry, _: f"{issuer_text(entry.issuer)} was refused {_request_text(entry)}: {denial_text(entry)}",
    "held": lambda entry, name: f"{_holder(entry)} began to hold {name} {_wanted(entry)}",
    "released": lambda entry, name: f"{_holder(entry)} no longer holds {name}",
    "ended": _ended_text,
    "expired": lambda entry, name: f"{_holder(entry)} no longer holds {name}: its time was over",
    "outranked": lambda entry, name: (
        f"{printable(entry.text, 60)}, which outranks the lease that holds {name} {_wanted(entry)}"
    ),
    "goal": lambda entry, _: printable(entry.text, 1000),
    "handed_back": lambda entry, name: f"{name} is held {_wanted(entry)} again",
    "changed": lambda entry, name: (
        f"{name} reported {_wanted(entry)}; {_REASONS.get(entry.cause, 'no command explains it')}"
    ),
}
"""The clause for each kind of entry, with the name of the device; for other kinds it is that of the outcome."""


def _request_text(entry: JournalEntry) -> str:
    """Return the refused request, in words after "was refused"."""
    if entry.settings:
        return f"to hold it {settings_text(entry.settings)}"
    facts = _facts(entry)
    operation = str(facts.get("operation", ""))
    target = printable(str(facts.get("target", "")), 100)
    wanted = f" {printable(entry.text)!r}" if entry.text else ""
    if operation == "publish":
        return f"to publish{wanted} on {target}"
    return f"{_REQUESTS.get(operation, operation)} {target}{' for' if wanted else ''}{wanted}".strip()


def _facts(entry: JournalEntry) -> Mapping[str, object]:
    return {fact.name: plain_value(fact.value) for verdict in entry.verdicts for fact in verdict.facts}


def _setting_text(setting: Setting | Reading) -> str:
    name, value = setting.capability, plain_value(setting.value)
    text = printable(value_text(name, value), 60)
    return text if isinstance(value, bool | str) else f"{name.replace('_', ' ')} {text}"


def chains_of(entries: Iterable[JournalEntry]) -> list[Chain]:
    """Group *entries* by command: entries of one command are adjacent, and a change is alone."""
    chains: list[Chain] = []
    for entry in entries:
        if chains and entry.command and chains[-1][0].command == entry.command:
            chains[-1].append(entry)
        else:
            chains.append([entry])
    return chains


def reason_text(chain: Chain, names: Mapping[str, str]) -> str:
    """Return a clause that explains why the device changed."""
    last, first = chain[-1], chain[0]
    if first.kind == "changed":
        return _REASONS.get(first.cause, _UNEXPLAINED)
    if last.kind == "reverted":
        asked = f"{issuer_text(first.issuer)} had asked for {settings_text(first.settings)}"
        return f"it changed back, {cause_text(last.cause)}, after {asked}"
    reported = [(entry.device, entry.part) for entry in chain if entry.kind == "reported"]
    if chain[0].kind == "requested" and bool(reported) and (chain[0].device, chain[0].part) not in reported:
        asked_part = f"asked {name_text(first.device, names, first.part)} for"
        return f"{_request_reason(first, names, asked_part)}; it changed along with that"
    reason = _request_reason(first, names, "published" if first.kind == "published" else "asked for")
    if last.kind == "reported" and any(entry.kind == "outcome" for entry in chain):
        return f"{reason}; it answered late, or somebody did it by hand"
    results = [entry.results[0] for entry in chain if entry.kind == "outcome"]
    doubt = next((printable(result.saw) for result in results if result.saw and result.witness), "")
    return f"{reason}; it reported that, but {doubt}" if doubt else reason


def _request_reason(first: JournalEntry, names: Mapping[str, str], verb: str) -> str:
    asked = f"{issuer_text(first.issuer)} {verb} {_describe_command(first)}"
    cause = trigger_text(first.trigger, names)
    return f"{asked}, because {cause}" if cause else asked


def finding_text(response: ExplainDeviceResponse, names: Mapping[str, str], now: float) -> str:
    """Return a sentence that explains since when and why a device is in its state."""
    goal = (f" {ago_text(entry.at, now).capitalize()}: {entry_text(entry, names)}." for entry in response.goal)
    return "".join((_finding_text(response, names, now), *goal))


def _finding_text(response: ExplainDeviceResponse, names: Mapping[str, str], now: float) -> str:
    chains = chains_of(response.entries)
    if response.finding == "none":
        no_change = "It reported no change after the newest command."
        return no_change if chains else "Nobody commanded it, and it reported no change."
    reason = reason_text(chains[-1], names) if chains else _UNEXPLAINED
    if response.finding == "event":
        event = chains[-1][-1].settings
        reason = f"{event[0].capability.replace('_', ' ')} {settings_text(event)}"
    return _FINDINGS[response.finding].format(ago=ago_text(response.changed_at, now), reason=reason)


def chain_lines(chains: Iterable[Chain], names: Mapping[str, str], now: float) -> Iterator[tuple[str, str]]:
    """Yield the steps of *chains*, each with its time, including the report that led to the first one."""
    for number, chain in enumerate(chains):
        trigger = chain[0].trigger
        if number == 0 and (cause := trigger_text(trigger, names)):
            yield clock_text(trigger.at, now) if trigger.at.sec else "", cause
        for entry in _informative(chain):
            yield clock_text(entry.at, now), entry_text(entry, names)


def was_obeyed(chain: Chain) -> bool:
    """Return whether the device obeyed *chain*, or already had the state, and is not known to have gone back."""
    results = [entry.results[0].outcome for entry in chain if entry.kind in {"outcome", "reverted"}]
    return bool(results) and has_succeeded(results[-1])


def result_text(chain: Chain, now: float) -> str:
    """Return the outcome of a command known at *now*, in seconds since 1970."""
    decided = [entry for entry in chain if entry.kind in {"outcome", "reverted"}]
    if decided:
        return entry_text(decided[-1], {})
    if chain[0].kind == "denied":
        return f"refused: {denial_text(chain[0])}"
    if would := [entry for entry in chain if entry.kind == "would"]:
        return entry_text(would[-1], {})
    if any(entry.kind == "published" for entry in chain):
        reports = [entry for entry in chain if entry.kind == "reported"]
        return f"it reported {settings_text(reports[-1].settings)}" if reports else "it reported nothing new"
    if now - to_seconds(chain[0].at) > _MAX_WAIT_S:
        return "its outcome is not known: homebot stopped before it was"
    return "its outcome is not known yet"


def _describe_command(entry: JournalEntry) -> str:
    return repr(entry.text) if entry.kind == "published" else settings_text(entry.settings)


def _informative(entries: Iterable[JournalEntry]) -> Iterator[JournalEntry]:
    """Yield the informative entries: an acknowledgement only with a route or without a report, a refusal only once."""
    shown = list(entries)
    has_report = any(entry.kind == "reported" for entry in shown)
    for before, entry in zip([None, *shown], shown, strict=False):
        if (entry.kind != "acknowledged" or entry.text or not has_report) and not repeats(entry, before):
            yield entry
