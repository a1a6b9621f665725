"""Damaged answers and notifications of a Shelly on its own WebSocket: refused in our words, or understood."""

import json
import math

from pydantic import SecretStr
from tests.fuzz.conftest import Fuzz
from tests.integrations.shelly.formats.rpc_documents import MODELS

from homebot.conventions.payload import as_fields, parse_object
from homebot.errors import RefusedError, WireError
from homebot.integrations.shelly.formats.gen2_rpc import Gen2RpcDevice, RpcLogin, is_setup_change

CHALLENGE = '{"auth_type":"digest","nonce":1625038762,"nc":1,"realm":"shellypro4pm-f008d1d8b8b8","algorithm":"SHA-256"}'
EVENTS = '{"method":"NotifyEvent","params":{"ts":1.0,"events":[{"component":"input:0","event":"single_push"}]}}'
WORDS = tuple(sorted({key for model in MODELS.values() for key in (*model.status, *model.config)}))


def test_damaged_frames_are_refused_or_read(fuzz: Fuzz) -> None:
    for mutate, rng in fuzz("shelly rpc", WORDS):
        model = rng.choice(list(MODELS.values()))
        device = Gen2RpcDevice(model.info["id"])
        frame = b"{}"
        for kind, answer in (("info", model.info), ("config", model.config), ("status", model.status)):
            try:
                frame = mutate.damaged_json(json.dumps({"id": 1, "src": "x", "result": answer}))
                device.record_answer(kind, as_fields(parse_object(frame).get("result")), len(frame))  # type: ignore[arg-type]
            except WireError:
                device.record_answer(kind, answer, 10)  # type: ignore[arg-type]
        page = mutate.damaged({"components": model.components, "offset": 0, "total": len(model.components)})
        device.add_page(as_fields(page))
        described = device.describe()
        assert described
        names = {
            (about.key, one.part.id): {able.name for able in one.part.capabilities}
            for about in described
            for one in about.parts
        }
        assert math.isfinite(device.stale_after)
        news = mutate.damaged_json(json.dumps({"method": "NotifyStatus", "params": model.status}))
        for one in (frame, news, mutate.damaged_json(EVENTS), device.components_status()):
            for read in (device.read_status(one), device.read_notification(one)):
                for part, readings in read:
                    assert readings.keys() <= names[part]
                    assert all(math.isfinite(value) for value in readings.values() if isinstance(value, float))
        is_setup_change(as_fields(mutate.value()))
        for part in [*names, (device.id, mutate.word())][:3]:
            try:
                calls, _ = device.calls(
                    part, {rng.choice(("on_off", "level", "position", "state")): mutate.plain()}, 0.0
                )
            except RefusedError:
                continue
            assert all(method.isprintable() for method, _ in calls)


def test_damaged_challenges_are_refused_or_signed(fuzz: Fuzz) -> None:
    for mutate, _ in fuzz("shelly challenges"):
        login = RpcLogin(SecretStr("correct horse"))
        try:
            login.accept_challenge(mutate.damaged_json(CHALLENGE).decode(errors="replace"))
        except WireError:
            assert not login.is_challenged
            continue
        assert "correct horse" not in json.dumps(login.sign())
