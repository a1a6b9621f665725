"""``homebot answer``, against a real directory and control layer."""

import json

import pytest
from tests.cli.conftest import NOW, HomebotWith, Run, run_at
from tests.cli.test_approve import home
from tests.patience import PATIENCE
from websockets.sync.client import connect

from homebot.clock import ManualClock

COMMAND = {"target": "Lamp", "command": "on", "ask_first": True}
"""The person at the shell and the asker are both the client without a token here."""


@pytest.fixture
def run(homebot_with: HomebotWith, capsys: pytest.CaptureFixture[str]) -> tuple[Run, str]:
    homebot = homebot_with(home, ManualClock(NOW))
    return run_at(homebot, capsys), homebot.door


def test_without_an_argument_it_lists_the_questions(run: tuple[Run, str]) -> None:
    homebot, door = run
    assert homebot("answer")[1].endswith("no question waits\n")
    with connect(f"ws://{door}", proxy=None) as asker:
        asker.send(json.dumps({"op": "subscribe", "topic": "/control/questions"}))
        asker.send(json.dumps({"op": "call_service", "id": "ask", "service": "/devices/command", "args": COMMAND}))
        question = json.loads(asker.recv(timeout=PATIENCE))["msg"]["questions"][0]["question"]
        listed = homebot("answer")[1]
        assert f"{question}  the client local wants: lamp → on  1 min" in listed
        code, told = homebot("answer", question, "yes")
        assert (code, "client:local asks, so another answers" in told) == (1, True)


def test_a_wrong_answer_says_what_to_do(run: tuple[Run, str]) -> None:
    homebot, _ = run
    code, told = homebot("answer", "1-2", "no")
    assert (code, "there is no such question now; `homebot answer` lists those that are open" in told) == (1, True)
    assert "answer yes or no: homebot answer 1-2 yes" in homebot("answer", "1-2")[1]
    with pytest.raises(SystemExit):
        homebot("answer", "1-2", "maybe")
