"""Recordings: whatever a file holds, it is read, or refused with a message; and no payload stops a recording."""

from tests.fuzz.conftest import Fuzz

from homebot.devices import RawMessage, Sighting
from homebot.devices.command_messages import CommandResult, Setting
from homebot.devices.gateway_messages import Report
from homebot.devices.part import Capability, Part
from homebot.devices.value import Reading, Value
from homebot.errors import UsageError
from homebot.messages import Time
from homebot.recording.lines import RecordedApp, RecordedCommand, RecordingHeader, RecordingLine, line_text, read_line
from homebot.recording.recording import read_recording
from homebot.recording.repetitions import Repetition
from homebot.recording.secrets import without_secrets
from homebot.replay.replay import replay_config

AT = Time(sec=1_767_225_600, nanosec=0)
APP = RecordedApp(name="lights_out", kind="homebot.apps.lights_out:LightsOut", settings='{"quiet_after": 60.0}')
LAMP = Part(id="l", service_type="light", capabilities=(Capability(name="on_off", settable=True),), reads=("a",))
MESSAGES = (
    RecordingHeader(format=2, version="1", home="home", started_at=AT, control='{"settle": 5.0}', apps=(APP,)),
    Sighting(
        gateway="mqtt",
        key="lamp",
        kind="appeared",
        why="it said so",
        name="Lamp",
        service_type="light",
        address="a",
        command_address="b",
        parts=(LAMP,),
        seen_at=AT,
        expires_at=AT,
        confirmed=True,
    ),
    Report(
        gateway="mqtt",
        key="lamp",
        readings=(Reading(part="l", capability="on_off", value=Value.of(True)),),
        retained=False,
        received_at=AT,
    ),
    Repetition(of="report", gateway="mqtt", key="lamp", at=AT),
    RawMessage(gateway="mqtt", key="lamp", address="a", payload=b"on", retained=False, received_at=AT),
    RecordedCommand(
        id="1", issuer="/app", device="lamp", settings=(Setting(capability="on_off", value=Value.of(False)),)
    ),
    CommandResult(command_id="1", outcome="confirmed", text="confirmed", latency=0.5, evidence=3),
)
LINES = [line_text(RecordingLine(float(number), message)) for number, message in enumerate(MESSAGES)]
WORDS = ("at", "kind", "message", "recording", "raw", "format", "on_off", "mqtt")


def test_a_damaged_recording_is_read_or_refused(fuzz: Fuzz) -> None:
    for mutate, rng in fuzz("recordings", WORDS):
        damaged = rng.randrange(len(LINES))
        lines = [mutate.damaged_json(text) if number == damaged else text.encode() for number, text in enumerate(LINES)]
        try:
            recording = read_recording(lines, "day")
            replay_config(recording)
        except UsageError as exc:
            assert str(exc)  # noqa: PT017 - each refusal says why


def test_what_is_read_is_written_in_the_same_way(fuzz: Fuzz) -> None:
    for mutate, rng in fuzz("recording lines", WORDS):
        text = mutate.damaged_json(rng.choice(LINES))
        try:
            line = read_line(text)
        except UsageError:
            continue
        again = read_line(line_text(line))
        assert line_text(again) == line_text(line)


def test_any_payload_can_be_recorded(fuzz: Fuzz) -> None:
    for mutate, _ in fuzz("recorded payloads", ("code", "pin", *WORDS)):
        payload = mutate.damaged_json('{"code": "1234", "state": {"on": true}}')
        kept = without_secrets(payload)
        assert without_secrets(kept) == kept
