"""The right ``ask``: nothing is sent before a person who may give the command says yes; in virtual time."""

from functools import partial

import anyio
import pytest
from tests.control.conftest import Home, hold_request, ignore
from tests.control.test_groups import put_group

from homebot.devices.command_messages import (
    CommandDevices,
    CommandDevicesRequest,
    CommandRequest,
    CommandResult,
    SendText,
    SendTextRequest,
    Setting,
)
from homebot.devices.handles import DoorLock
from homebot.devices.names import ANSWER_QUESTION, COMMAND_DEVICES, GET_QUESTIONS, OPEN_QUESTIONS, SEND_TEXT
from homebot.devices.question_messages import (
    AnswerQuestion,
    AnswerQuestionRequest,
    AnswerQuestionResponse,
    GetQuestions,
    OpenQuestion,
    OpenQuestions,
)
from homebot.devices.value import Value
from homebot.graph import qos_profile_latched

pytestmark = pytest.mark.virtual_time

AGENT = ("act: light", "ask: lock in hall")
OWNER = ("act: all",)


async def put_house(home: Home) -> None:
    home.put("lamp", "light", "on_off", area="hall")
    home.put("door", "door_lock", "lock", area="hall")
    await home.report("door", "lock", "locked")
    await home.handle(DoorLock, "door")


class Asker:
    """A client whose commands run beside the test."""

    def __init__(self, home: Home, *scope: str, issuer: str = "client:agent") -> None:
        self.home, self.scope, self.issuer = home, scope or AGENT, issuer
        self.results: list[CommandResult] = []
        self.waiting: anyio.CancelScope

    async def begin(self, value: str = "unlocked", *, ask_first: bool = False) -> None:
        """Command the lock, and let the house handle it."""
        device = (await self.home.handle(DoorLock, "door")).device.id
        setting = Setting(capability="lock", value=Value.of(value))
        request = CommandRequest(
            device=device, settings=(setting,), issuer=self.issuer, scope=self.scope, ask_first=ask_first
        )
        self.home.tasks.start_soon(self._perform, request)
        await anyio.sleep(0.1)

    async def _perform(self, request: CommandRequest) -> None:
        with anyio.CancelScope() as self.waiting:
            self.results.append(CommandResult.of(await self.home.control.perform(request)))


async def open_questions(home: Home) -> tuple[OpenQuestion, ...]:
    return (await home.app.create_client(GetQuestions, GET_QUESTIONS).call(GetQuestions.Request())).questions


async def answer(home: Home, *, yes: bool, issuer: str = "client:owner", scope: tuple[str, ...] = OWNER) -> str:
    """Answer the oldest question; return why that does not count, or nothing."""
    question = (await open_questions(home))[0].question
    request = AnswerQuestionRequest(question=question, yes=yes, issuer=issuer, scope=scope)
    answered: AnswerQuestionResponse = await home.app.create_client(AnswerQuestion, ANSWER_QUESTION).call(request)
    assert answered.success is (not answered.message)
    await anyio.sleep(0.1)
    return answered.message


async def test_nothing_is_sent_before_a_person_says_yes(home: Home) -> None:
    await put_house(home)
    agent = Asker(home)
    await agent.begin()
    (question,) = await open_questions(home)
    assert question.text == "the client agent wants: door → unlocked"
    assert (home.commands, agent.results) == ([], [])
    assert await answer(home, yes=True) == ""
    assert agent.results[0].outcome == "confirmed"
    assert agent.results[0].command_id == question.question
    assert await open_questions(home) == ()
    verdicts = [one for entry in (await home.read()).entries for one in entry.verdicts]
    assert [(one.policy, one.allowed, one.reason) for one in verdicts] == [("ask", True, "client:owner said yes")]


async def test_what_the_right_does_not_name_is_commanded_or_refused_without_a_question(home: Home) -> None:
    await put_house(home)
    request = CommandDevicesRequest(target="Lamp", command="on", issuer="client:agent", scope=AGENT)
    client = home.app.create_client(CommandDevices, COMMAND_DEVICES)
    assert (await client.call(request)).outcome == "confirmed"
    agent = Asker(home, "act: light", "ask: lock in attic")
    await agent.begin()
    assert (agent.results[0].outcome, agent.results[0].policy) == ("refused", "rights")
    assert await open_questions(home) == ()


async def test_no_refuses_the_command_and_the_same_one_a_minute_long_without_a_question(home: Home) -> None:
    await put_house(home)
    agent = Asker(home)
    await agent.begin()
    assert await answer(home, yes=False) == ""
    await agent.begin()
    assert [(one.outcome, one.policy, one.reason) for one in agent.results] == [
        ("refused", "ask", "client:owner said no"),
        ("refused", "ask", "client:owner said no a moment ago"),
    ]
    await agent.begin("open")
    assert len(await open_questions(home)) == 1  # another command
    await anyio.sleep(60)
    await agent.begin()
    assert len(await open_questions(home)) == 1
    assert home.commands == []


async def test_without_an_answer_it_is_refused_after_a_minute_with_the_reason(home: Home) -> None:
    await put_house(home)
    agent = Asker(home)
    await agent.begin()
    await anyio.sleep(59.8)
    assert agent.results == []
    await anyio.sleep(0.2)
    assert (agent.results[0].outcome, agent.results[0].policy) == ("refused", "ask")
    assert agent.results[0].reason.startswith(
        "nobody answered within 60 s: a person does on the page, or with `homebot"
    )
    assert (home.commands, await open_questions(home)) == ([], ())
    outcomes = [one.outcome for entry in (await home.read()).entries for one in entry.results]
    assert outcomes == ["refused"]


@pytest.mark.parametrize(
    ("issuer", "scope", "problem"),
    [
        ("client:agent", AGENT, "client:agent asks, so another answers: use the owner's token"),
        ("client:agent", OWNER, "client:agent asks, so another answers"),
        ("client:other", AGENT, "client:other must ask itself"),
        ("client:other", ("act: all", "ask: all"), "client:other must ask itself"),
        ("client:panel", ("act: harmless",), "client:panel may not command door"),
        ("client:panel", ("manage",), "client:panel may not command door"),
        ("client:local", (), "client:local may not command door"),
        ("/app", (), "only a person answers"),
        ("", (), "only a person answers"),
    ],
)
async def test_who_may_not_give_the_command_unasked_does_not_answer(
    home: Home, issuer: str, scope: tuple[str, ...], problem: str
) -> None:
    await put_house(home)
    agent = Asker(home)
    await agent.begin()
    assert (await answer(home, yes=True, issuer=issuer, scope=scope)).startswith(problem)
    assert (home.commands, agent.results, len(await open_questions(home))) == ([], [], 1)


async def test_a_question_is_answered_once(home: Home) -> None:
    await put_house(home)
    home.behaviours["door"] = ignore
    agent = Asker(home)
    await agent.begin()
    (question,) = await open_questions(home)
    request = AnswerQuestionRequest(question=question.question, yes=False, issuer="client:owner", scope=OWNER)
    client = home.app.create_client(AnswerQuestion, ANSWER_QUESTION)
    first, second = await client.call(request), await client.call(request.model_copy(update={"yes": True}))
    assert (first.success, second.success) == (True, False)
    assert second.message == "the question is over: client:owner said no"
    await anyio.sleep(0.1)
    assert agent.results[0].reason == "client:owner said no"


@pytest.mark.parametrize(("is_cancelled", "end"), [(True, "the client agent asks no more"), (False, "nobody answered")])
async def test_a_late_answer_is_told_why_it_does_not_count(home: Home, *, is_cancelled: bool, end: str) -> None:
    await put_house(home)
    agent = Asker(home)
    await agent.begin()
    (question,) = await open_questions(home)
    agent.waiting.cancel() if is_cancelled else await anyio.sleep(60)
    await anyio.sleep(0.1)
    request = AnswerQuestionRequest(question=question.question, yes=True, issuer="client:owner", scope=OWNER)
    client = home.app.create_client(AnswerQuestion, ANSWER_QUESTION)
    assert (await client.call(request)).message.startswith(f"the question is over: {end}")
    unknown = await client.call(request.model_copy(update={"question": "of an earlier homebot"}))
    assert unknown.message.startswith("there is no such question now")
    assert home.commands == []


@pytest.mark.parametrize("scope", [("act: all", "ask: lock"), ("act: lock", "ask: in hall"), ("ask: all",)])
async def test_ask_holds_beside_any_other_right(home: Home, scope: tuple[str, ...]) -> None:
    await put_house(home)
    agent = Asker(home, *scope)
    await agent.begin()
    assert (len(await open_questions(home)), agent.results) == (1, [])
    await agent.begin("locked")  # what makes the house safer too
    assert len(await open_questions(home)) == 2


async def test_a_right_that_names_no_lock_gives_none_by_an_answer(home: Home) -> None:
    await put_house(home)
    agent = Asker(home, "ask: in hall")
    await agent.begin()
    assert (agent.results[0].outcome, agent.results[0].policy) == ("refused", "rights")


async def test_a_text_and_a_command_in_words_ask_as_well_and_nothing_is_held(home: Home) -> None:
    await put_house(home)
    device = (await home.handle(DoorLock, "door")).device.id
    answers: list[object] = []

    async def text() -> None:
        request = SendTextRequest(device=device, payload="unlock", issuer="client:agent", scope=AGENT)
        answers.append((await home.app.create_client(SendText, SEND_TEXT).call(request, timeout=100)).problem)

    async def words() -> None:
        request = CommandDevicesRequest(target=device, command="unlock", issuer="client:agent", scope=AGENT)
        client = home.app.create_client(CommandDevices, COMMAND_DEVICES)
        answers.append((await client.call(request, timeout=100)).results[0].result.policy)

    for way, refused in ((text, "refused"), (words, "ask")):
        home.tasks.start_soon(way)
        await anyio.sleep(0.1)
        assert len(await open_questions(home)) == 1
        assert await answer(home, yes=False) == ""
        assert answers[-1] == refused
        await anyio.sleep(61)
    held = await home.hold(hold_request(device, "lock", "unlocked", "client:agent", scope=AGENT))
    assert (held.held, held.result.policy) == (False, "rights")
    assert "a person must agree to each command of client:agent" in held.result.reason
    assert home.commands == []


async def test_what_is_cancelled_while_a_person_is_asked_has_one_outcome_in_the_journal(home: Home) -> None:
    """Also a text."""
    await put_house(home)
    agent = Asker(home)
    await agent.begin()
    agent.waiting.cancel()
    text = SendTextRequest(device="door", payload="unlock", issuer="client:agent", scope=AGENT)
    with anyio.move_on_after(0.1):
        await home.app.create_client(SendText, SEND_TEXT).call(text, cancel_with_caller=True)
    ends = [one.results[0].text for one in (await home.read()).entries if one.kind == "outcome"]
    assert ends == ["not sent: it was cancelled"] * 2


async def test_one_client_has_five_open_questions_at_most(home: Home) -> None:
    await put_house(home)
    agent = Asker(home)
    for _ in range(6):
        await agent.begin()
    assert len(await open_questions(home)) == 5
    assert [one.reason for one in agent.results] == ["5 questions wait for an answer already"]
    await Asker(home, issuer="client:other").begin()
    assert len(await open_questions(home)) == 6


async def test_the_command_is_for_the_lock_as_it_is_when_the_answer_comes(home: Home) -> None:
    await put_house(home)
    agent = Asker(home)
    await agent.begin()
    await home.report("door", "lock", "unlocked")
    await answer(home, yes=True)
    assert agent.results[0].outcome == "already_so"
    await agent.begin("locked")
    home.gateway.devices.remove("door", "the test says so")
    await answer(home, yes=True)
    assert agent.results[1].outcome == "gone"
    assert home.commands == []


async def test_the_question_of_a_client_that_left_is_over(home: Home) -> None:
    await put_house(home)
    agent = Asker(home)
    await agent.begin()
    agent.waiting.cancel()
    await anyio.sleep(0.1)
    assert (await open_questions(home), home.commands) == ((), [])
    outcomes = [one.outcome for entry in (await home.read()).entries for one in entry.results]
    assert outcomes == ["no_answer"]


async def test_a_client_with_the_right_may_have_a_person_asked(home: Home) -> None:
    """As ``homebot mcp`` does where the agent's program cannot ask."""
    await put_house(home)
    agent = Asker(home, "act: all")
    await agent.begin(ask_first=True)
    assert home.commands == []
    await answer(home, yes=True)
    assert agent.results[0].outcome == "confirmed"


async def test_the_questions_are_published_with_their_end_for_who_comes_later_too(home: Home) -> None:
    await put_house(home)
    await Asker(home).begin()
    now = home.graph.clock.now()
    told = home.app.create_subscription(OpenQuestions, OPEN_QUESTIONS, None, qos_profile_latched)
    (question,) = (await told.receive()).questions
    assert question.until.to_seconds() - now == pytest.approx(60, abs=0.5)
    await answer(home, yes=False)
    assert (await told.receive()).questions == ()


async def test_a_group_is_commanded_by_an_answer_if_one_of_its_members_is(home: Home) -> None:
    """Otherwise the group would be the way around."""
    group = await put_group(home, "id:left", "id:right", room="bedroom")
    setting = Setting(capability="on_off", value=Value.of(True))
    for scope, is_asked in ((("act: all", "ask: in bedroom"), True), (("act: all", "ask: in hall"), False)):
        request = CommandRequest(device=group.device.id, settings=(setting,), issuer="client:agent", scope=scope)
        home.begin(partial(home.control.perform, request))
        await anyio.sleep(0.1)
        assert (len(await open_questions(home)), len(home.commands)) == ((1, 0) if is_asked else (0, 1))
        if is_asked:
            assert await answer(home, yes=False) == ""
