"""A device described by a Thing Description: its values are observed or polled, its commands sent.

Affordances with one address share its observation or poll.
An affordance whose observation fails is polled. Requests for values are sequential, for the sake of small devices.
"""

from __future__ import annotations

from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Protocol

import anyio

from homebot.conventions.command_values import require_true
from homebot.conventions.description import Publication, Publications
from homebot.conventions.payload import clean_text, shown
from homebot.devices.capabilities import implied_settings
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.errors import LinkError, RefusedError, UnableError, WireError
from homebot.gateways.announced.device_runner import DriverHost
from homebot.gateways.announced.gateway_device import GatewayDevice, ShowingCodec
from homebot.integrations.things.formats.binding import Binding, ClassifiedAffordance, ClassifiedPart, RequestBinding
from homebot.integrations.things.formats.classify import parts_of
from homebot.integrations.things.formats.payload import decode_document, encode_document
from homebot.integrations.things.formats.thing import Form, Thing, facts_of, identifiers_of
from homebot.support.isolation import run_as, ungrouped


@dataclass(frozen=True, slots=True)
class ThingPayload:
    """A payload from a thing, with the content type of its answer; empty for none."""

    data: bytes
    content_type: str = ""


class ThingPort(Protocol):
    """A protocol of requests and responses, with the credentials of one thing.

    Every call is limited in time and length of the answer. It raises :class:`homebot.errors.LinkError` if the thing
    does not answer, :class:`homebot.errors.RefusedError` if it refuses, and :class:`homebot.errors.WireError` if its
    answer breaks the protocol.
    """

    @property
    def binding(self) -> RequestBinding: ...  # noqa: D102 - see Attributes

    async def read(self, form: Form) -> ThingPayload:
        """Return the current value at the address of *form*."""
        ...

    async def write(self, form: Form, payload: bytes) -> None:
        """Send *payload*, empty for an action without input, by *form*; return when it was accepted."""
        ...

    def observe(self, form: Form, read_current: Callable[[], Awaitable[None]]) -> AsyncIterator[ThingPayload]:
        """Yield pushed values until the caller stops; the end of the observation is an error.

        Args:
            read_current: Reads the current value; called after the start of an observation that does not begin with it,
                so that no change is lost.
        """
        ...


MAX_OBSERVATIONS = 32
"""Most observations of one thing; further values are polled."""

POLL_EVERY = 30.0
"""Seconds between polls."""


def describe_thing(thing: Thing, key: str, binding: Binding, *others: str) -> GatewayDevice:
    """Return *thing* as a device, by the forms that a *binding* chooses; *others* are identities such as its host."""
    parts = parts_of(thing, binding)
    return GatewayDevice(
        key=key,
        name=clean_text(thing.title) or key,
        parts=tuple(part.part.model_copy(update={"name": clean_text(part.part.name)}) for part in parts),
        codecs={part.part.id: _RequestCodec(part, binding) for part in parts},
        metadata=facts_of(thing),
        identifiers=identifiers_of(thing, *others),
        area=clean_text(thing.area),
    )


@dataclass(frozen=True)
class _RequestCodec(ShowingCodec):
    """The codec of a part, which shows its requests."""

    part: ClassifiedPart
    binding: Binding

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> Publications:
        del transition
        by, form, value = self.part.settable[capability].request(value)
        return (Publication(f"{form.method} {form.href}".strip(), _encode(self.binding, by, form, value)),)


def _encode(binding: Binding, affordance: ClassifiedAffordance, form: Form, value: PlainValue) -> bytes:
    if affordance.affordance.kind == "action" and affordance.capability.name == "push":
        require_true(affordance.capability.name, value)
        return b""
    format_ = binding.formats(form.content_type)
    if format_ is None:
        raise UnableError(f"the content type {form.content_type[:60]!r} is not understood")
    return format_.encode(encode_document(affordance.capability, affordance.affordance, value))


@dataclass(slots=True, eq=False)
class _ThingSource:
    """An address of a thing, and the affordances with values there.

    Attributes:
        affordances: The affordances, each with the id of its part.
        instead: The sources to poll if this one is refused.
    """

    form: Form
    affordances: list[tuple[str, ClassifiedAffordance]] = field(default_factory=list)
    instead: tuple[_ThingSource, ...] = ()


class ThingDevice:
    """The values and commands of one thing; values that are not pushed are polled every *poll_every* seconds."""

    def __init__(
        self,
        thing: Thing,
        device: GatewayDevice,
        port: ThingPort,
        host: DriverHost,
        poll_every: float = POLL_EVERY,
    ) -> None:
        self._device = device
        self._port = port
        self._host = host
        self._poll_every = poll_every
        self._parts: tuple[ClassifiedPart, ...] = parts_of(thing, port.binding)
        self._asked: list[_ThingSource] = []
        self._asks_now = anyio.Event()
        self._turn = anyio.Lock()
        self._is_reached = False
        self._refusal: RefusedError | None = None

    async def run(self) -> None:
        """Describe the device and report its values, until cancelled.

        Raises:
            LinkError: It does not answer, or an observation was lost.
            PeerError: It refuses to be read.
        """
        self._is_reached, self._refusal = False, None
        self._host.describe(self._device)
        observed = self._sources()
        with ungrouped():
            async with anyio.create_task_group() as tasks:
                for source in observed:
                    tasks.start_soon(run_as, "the observation of a thing", partial(self._observe, source))
                tasks.start_soon(run_as, "the polling of a thing", self._poll)

    async def perform(self, command: Command) -> None:
        """Carry out a command; return when the thing has accepted it."""
        settable = next((part.settable for part in self._parts if part.part.id == command.part), {})
        if command.capability not in settable:
            raise UnableError(f"{command.capability[:40]} of {command.part[:40]!r} cannot be set")
        values = implied_settings(command.capability, command.value.plain(), settable)
        requests = [(settable[name], *settable[name].request(value)) for name, value in values]
        payloads = [
            (affordance, form, _encode(self._port.binding, by, form, value)) for affordance, by, form, value in requests
        ]
        for affordance, form, payload in payloads:
            await self._port.write(form, payload)
            if any(affordance is asked for source in self._asked for _, asked in source.affordances):
                self._asks_now.set()

    def _sources(self) -> tuple[_ThingSource, ...]:
        """Split the readable properties into observed (returned) and polled ones."""
        binding = self._port.binding
        observed: list[tuple[Form, str, ClassifiedAffordance]] = []
        asked: list[tuple[Form, str, ClassifiedAffordance]] = []
        pushing: set[str] = set()
        for part in self._parts:
            for affordance in part.affordances:
                pushed, read = binding.push_forms(affordance.affordance), binding.read_forms(affordance.affordance)
                if affordance.observed is None:
                    continue
                if pushed and (len(pushing) < MAX_OBSERVATIONS or pushed[0].href in pushing):
                    pushing.add(pushed[0].href)
                    observed.append((pushed[0], part.part.id, affordance))
                elif read:
                    asked.append((read[0], part.part.id, affordance))
        self._asked = list(_group(asked))
        sources = _group(observed)
        for source in sources:
            forms = [
                (binding.read_forms(affordance.affordance), part, affordance) for part, affordance in source.affordances
            ]
            source.instead = _group([(read[0], part, affordance) for read, part, affordance in forms if read])
        return sources

    async def _observe(self, source: _ThingSource) -> None:
        try:
            await self._follow(source)
        except (RefusedError, WireError) as exc:
            self._log("things.not_observed", "cannot be observed, and is read instead", source, exc)
        else:
            raise LinkError(f"the observation of {source.form.href[:200]} ended")
        self._asked += source.instead
        self._asks_now.set()

    async def _follow(self, source: _ThingSource) -> None:
        observation = self._port.observe(source.form, partial(self._ask_all, source.instead))
        try:
            async for payload in observation:
                try:
                    await self._report_payload(source, payload)
                except WireError as exc:
                    self._host.reject(payload.data, str(exc))
        finally:
            if isinstance(observation, AsyncGenerator):
                with anyio.CancelScope(shield=True):
                    await observation.aclose()

    async def _poll(self) -> None:
        while True:
            self._asks_now = anyio.Event()
            await self._ask_all(self._asked)
            if not self._is_reached and self._refusal is not None and not self._asks_now.is_set():
                raise self._refusal
            with anyio.move_on_after(self._poll_every):
                await self._asks_now.wait()

    async def _ask_all(self, sources: Iterable[_ThingSource]) -> None:
        for source in tuple(sources):
            try:
                async with self._turn:
                    payload = await self._port.read(source.form)
                await self._report_payload(source, payload)
            except RefusedError as exc:
                self._refusal = exc
                self._log("things.not_read", "cannot be read", source, exc)
            except WireError as exc:
                self._host.reject(exc.frame, str(exc))

    def _log(self, event: str, problem: str, source: _ThingSource, error: Exception) -> None:
        href = source.form.href[:200]
        self._host.log.info(event, message=f"{href} {problem}: {str(error)[:200]}", href=href)

    async def _report_payload(self, source: _ThingSource, payload: ThingPayload) -> None:
        if not self._is_reached:
            self._is_reached = True
            self._host.report_reachable(reachable=True)
        await self._host.deliver_raw(payload.data)
        formats, form = self._port.binding.formats, source.form
        format_ = formats(payload.content_type or form.response_type or form.content_type)
        if format_ is None:
            raise WireError(f"the content type {payload.content_type[:60]!a} is not understood")
        document = format_.parse(payload.data)
        for part, affordance in source.affordances:
            await self._report_value(part, affordance, document, payload)

    async def _report_value(
        self, part: str, source: ClassifiedAffordance, document: object, payload: ThingPayload
    ) -> None:
        value = decode_document(source.capability, source.affordance, document)
        if value is None:
            self._host.reject(payload.data, f"{source.affordance.name[:60]!a} cannot be {shown(document)}")
        else:
            await self._host.report({source.capability.name: value[0]}, part)


def _group(read: Iterable[tuple[Form, str, ClassifiedAffordance]]) -> tuple[_ThingSource, ...]:
    sources: dict[tuple[str, str, str], _ThingSource] = {}
    for form, part, affordance in read:
        sources.setdefault((form.href, form.method, form.subprotocol), _ThingSource(form)).affordances.append(
            (part, affordance)
        )
    return tuple(sources.values())
