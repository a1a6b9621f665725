"""Raw texts to devices: checked as the commands that they stand for, sent once, and not verified."""

from dataclasses import replace
from typing import Final, Literal, final

from homebot.control.command import IssuedCommand
from homebot.control.executor import CommandExecutor
from homebot.control.journal.given_codes import CODE_GIVEN, MAY_BE_CODE, public_text, takes_code
from homebot.control.journal.journal import CommandJournal
from homebot.control.policy_engine import PolicyEngine
from homebot.devices import Device, DevicePart
from homebot.devices.always_ask import always_asks
from homebot.devices.command_messages import SendTextRequest, SendTextResponse, Setting
from homebot.devices.command_sender import TextSender, TextTarget
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.outcomes import Gone, NoAnswer, Outcome, Refused
from homebot.devices.part import Part
from homebot.devices.text.commands import decode_command, part_at
from homebot.devices.value import PlainValue
from homebot.errors import LinkError, RefusedError, ServiceError
from homebot.graph import Node

__all__ = ["UNREAD", "TextCommands"]

UNREAD: Final = "raw_text"
"""The capability of a text with an unknown effect; only the verb ``use`` matches it."""

_LONGEST_NOTED: Final = 500
_MAY_BE_CODE: Final = MAY_BE_CODE | {UNREAD}
_ALWAYS_ASK: Final = "always_ask"
_UNREADABLE: Final = "it always asks, and this text cannot be decoded as a command; command it by its handle"


@final
class TextCommands:
    """Serves the texts of applications."""

    def __init__(
        self,
        node: Node,
        lookup: DeviceLookup,
        executor: CommandExecutor,
        policies: PolicyEngine,
        journal: CommandJournal,
    ) -> None:
        self._clock = node.graph.clock
        self._lookup = lookup
        self._executor = executor
        self._policies = policies
        self._journal = journal
        self._sender = TextSender(node)

    async def send(self, request: SendTextRequest) -> SendTextResponse:
        """Send a text, and return when its gateway has queued it; never raises."""
        device = None
        try:
            device = await self._lookup.device(request.device)
            if device is None:
                return self._failed(request, Gone())
            target = self._sender.target(device, request.payload)
        except RefusedError as exc:
            return self._failed(request, Refused("gateway", exc.reason), device)
        except (LinkError, ServiceError) as exc:
            return self._failed(request, NoAnswer(0.0, str(exc)), device)
        return await self._send(request, device, target)

    async def _send(self, request: SendTextRequest, device: Device, target: TextTarget) -> SendTextResponse:
        part = part_at(device, target.gateway, target.address) or _unknown_part(device)
        capability, value = _setting(request.payload, part)
        is_code = capability in _MAY_BE_CODE and takes_code(device, part.part)
        shown = Setting.of(capability, CODE_GIVEN) if is_code else _shown(capability, value, target.address)
        now = self._clock.now()
        command = IssuedCommand(
            id=self._journal.requested(request.issuer, (device.id, part.id), (shown,), request.trigger, now, device),
            device=device,
            part=part,
            settings={capability: value},
            issuer=request.issuer,
            rights=self._policies.rights(request.issuer),
            trigger=request.trigger,
            issued_at=now,
            scope=request.scope,
        )
        refused = self._refusal(command)
        if refused is None and await self._executor.questions.must_ask(command):
            refused = await self._executor.questions.ask(command, (shown,)) or self._refusal(command)
        if refused is not None:
            return self._ended(request, part.id, refused)
        if self._executor.rehearsal is not None and (assumed := self._executor.rehearse(command)) is not None:
            self._journal.decided(request.issuer, command.place, assumed)
            is_refused = isinstance(assumed, Refused)
            return _response(assumed) if is_refused else SendTextResponse(success=True, command_id=command.id)
        await self._executor.record_text(command)
        try:
            sent = await self._sender.send(
                request.payload, target, request.issuer, request.trigger, command.id, part.routes
            )
        except LinkError as exc:
            return self._ended(request, part.id, NoAnswer(0.0, str(exc), command_id=command.id))
        self._journal.published(device.id, sent, self._clock.now(), is_code=is_code)
        return SendTextResponse(success=True, others=target.others, command_id=command.id)

    def _refusal(self, command: IssuedCommand) -> Refused | None:
        refused = self._executor.check(command)
        if UNREAD in command.settings and any(always_asks(command.device, one) for one in command.device.parts):
            refused = refused or Refused(_ALWAYS_ASK, _UNREADABLE, command_id=command.id)
        return refused

    def _failed(self, request: SendTextRequest, outcome: Outcome, device: Device | None = None) -> SendTextResponse:
        """Record and return the failure of a text that is not decoded."""
        is_code = device is not None and any(takes_code(device, one.part) for one in device.parts)
        shown = Setting.of(UNREAD, CODE_GIVEN) if is_code else _shown(UNREAD, request.payload, "")
        place = (request.device, "")
        name = self._journal.requested(request.issuer, place, (shown,), request.trigger, self._clock.now(), device)
        return self._ended(request, "", replace(outcome, command_id=name))

    def _ended(self, request: SendTextRequest, part: str, outcome: Outcome) -> SendTextResponse:
        self._journal.decided(request.issuer, (request.device, part), outcome)
        return _response(outcome)


def _setting(payload: str, part: DevicePart) -> tuple[str, PlainValue]:
    """Return the setting of *payload* for *part*; the case and surrounding spaces of a word may differ."""
    for text in (payload, payload.strip().casefold()):
        try:
            return decode_command(text, part.part)
        except RefusedError:
            continue
    return UNREAD, payload


def _shown(capability: str, value: PlainValue, address: str) -> Setting:
    if isinstance(value, str):
        text = public_text(value, address) if capability == UNREAD else value
        return Setting.of(capability, text[:_LONGEST_NOTED])
    return Setting.of(capability, value)


def _unknown_part(device: Device) -> DevicePart:
    """Return a stand-in for an unknown part at the address."""
    return DevicePart(id="", part=Part(id="", service_type=device.service_type), routes=())


def _response(outcome: Outcome) -> SendTextResponse:
    message = outcome.text
    if isinstance(outcome, Refused):
        message = f"{outcome.reason} ({outcome.policy})"
    elif isinstance(outcome, NoAnswer):
        message = outcome.reason
    problem: Literal["refused", "unreachable"] = "unreachable" if isinstance(outcome, NoAnswer) else "refused"
    return SendTextResponse(success=False, message=message, problem=problem, command_id=outcome.command_id)
