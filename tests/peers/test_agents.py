"""Agents: the client of the MCP SDK, raw JSON-RPC, and a validator of OpenAPI, each against a running homebot."""

import importlib
import json
import sys
from collections.abc import Mapping
from itertools import cycle
from pathlib import Path
from typing import Any

import anyio
import pytest
from anyio.abc import SocketAttribute, SocketStream
from anyio.streams.buffered import BufferedByteReceiveStream
from tests.bridges.home_api.api import HISTORY, TOKENS, Api, bearer, running_api
from tests.patience import PATIENCE
from tests.peers.agent_trials import GOES_ON, trial_of
from websockets.asyncio.client import connect

from homebot.bridges.home_api.routes import openapi_text
from homebot.cli.server_address import ServerAddress

FOUR_LAMPS = 440  # bytes

TOOLS = {
    "home",
    "find_devices",
    "command",
    "why",
    "journal",
    "history",
    "scenes",
    "apply_scene",
    "achieve",
    "identify",
    "propose_routine",
    "try_routine",
    "explain_routine",
    "habits",
}


def arguments(api: Api, folder: Path, token: str) -> list[str]:
    return ["-m", "homebot", "mcp", "--door", f"127.0.0.1:{api.port}", "--token-file", str(folder / token)]


def outcome_of(body: Mapping[str, object]) -> str:
    """Return the answer of a homebot that confirms, and tells what it was asked."""
    return json.dumps({"id": "id", "outcome": "confirmed", "text": json.dumps(body)})


def test_the_description_is_valid_openapi() -> None:
    validator: Any = pytest.importorskip("openapi_spec_validator")
    validator.validate(json.loads(openapi_text()))


async def check_proposal(session: Any, api: Api) -> None:
    """An agent proposes a routine with a trial; a wrong one is refused with the reason."""
    text = f'name = "Agent {api.port} {id(session)}"\nwhen = ["lamp1 on"]\ndo = ["lamp2 of"]\n'
    wrong = await session.call_tool("propose_routine", {"text": text})
    assert (wrong.is_error, "did you mean off" in wrong.content[0].text) == (True, True)
    right = text.replace("lamp2 of", "lamp2 off")
    done = await session.call_tool("propose_routine", {"text": right})
    answer = json.loads(done.content[0].text)
    assert answer["text"].startswith("proposed Agent")
    assert "the owner enables it" in answer["text"]
    trial = answer["trial"] if answer["trial"] != [GOES_ON] else await trial_of(session, right)
    assert "would have given" in trial[-1] or trial == ["no trial: it needs a token"]


async def light(api: Api, lit: int) -> None:
    """Publish what a robot sees: 100 with noise, and *lit* while lamp2 is on; until cancelled."""
    noise = cycle((0.1, 1.7, 0.6, 1.2, 0.3, 1.9, 0.8))
    async with connect(f"ws://127.0.0.1:{api.port}", proxy=None) as door:
        await door.send(json.dumps({"op": "advertise", "topic": "/rosie/light", "type": "std_msgs/Float64"}))
        while True:
            lamp = (await api.get("/api/devices/lamp2")).values
            message = {"data": 100 + lit * lamp["on"] + next(noise)}
            await door.send(json.dumps({"op": "publish", "topic": "/rosie/light", "msg": message}))
            await anyio.sleep(0.1)


async def test_an_agent_identifies_a_lamp_hears_of_the_progress_and_what_it_may_not(
    tmp_path: Path,
) -> None:
    mcp: Any = pytest.importorskip("mcp.client.client")
    server: Any = pytest.importorskip("homebot.bridges.home_api.agent_server")
    heard: list[str] = []

    async def progress(_: float, __: float | None, message: str | None) -> None:
        heard.append(message or "")

    async def called(token: str, **given: object) -> Any:
        address = ServerAddress("127.0.0.1", api.port, TOKENS[token][0])
        client = await anyio.to_thread.run_sync(
            importlib.import_module("homebot.cli.mcp_server").ApiClient, address
        )  # it reads files
        asked = {"sensor": "/rosie/light", "at_night": True, **given}
        async with mcp.Client(server.house_server(client)) as session:
            return json.loads((await session.call_tool("identify", asked, progress_callback=progress)).content[0].text)

    async with running_api(tmp_path, **HISTORY) as api, anyio.create_task_group() as tasks:
        tasks.start_soon(light, api, 80)
        before = (await api.get("/api/devices")).values
        found = await called("agent", devices="light")
        assert found["message"] == "lamp2 is in view", found
        assert [one["device"] for one in found["candidates"]] == [f"lights/lamp{number}" for number in range(1, 5)]
        assert heard[-1].startswith("lamp2 99%") or heard[-1].startswith("lamp2 100%")
        assert (await called("agent", devices="lamp1"))["message"].startswith("lamp1 is not in view")
        reader = await called("reader", devices="light")
        assert (reader["outcome"], "the right act is missing" in reader["reason"]) == ("refused", True), reader
        assert (await api.get("/api/devices")).values == before
        with anyio.move_on_after(4.0):  # an agent that gives up
            await called("agent", devices="light")
        await api.until("/api/devices", lambda found: found == before)
        tasks.cancel_scope.cancel()


@pytest.mark.newest("mcp")
@pytest.mark.parametrize("mode", ["auto", "legacy"])
async def test_the_client_of_the_sdk_finds_commands_and_asks_a_person(tmp_path: Path, mode: str) -> None:
    """Of both protocols: in the older one the server asks, in the newer one the client calls again."""
    mcp: Any = pytest.importorskip("mcp.client.client")
    stdio: Any = pytest.importorskip("mcp.client.stdio")
    types: Any = pytest.importorskip("mcp.types")
    asked: list[str] = []
    answers = iter(["decline", "accept"])

    async def person(_: object, question: Any) -> Any:
        asked.append(question.message)
        action = next(answers)
        return types.ElicitResult(action=action, content={"confirm": True} if action == "accept" else None)

    async with running_api(tmp_path, **HISTORY) as api:

        def client(token: str, **more: Any) -> Any:
            started = stdio.StdioServerParameters(command=sys.executable, args=arguments(api, tmp_path, token))
            return mcp.Client(stdio.stdio_client(started), mode=mode, **more)

        async def call(session: Any, tool: str, **given: object) -> Any:
            result = await session.call_tool(tool, given)
            answer = json.loads(result.content[0].text)
            assert (result.is_error, result.structured_content) == (False, answer), answer
            return answer

        async with client("keys", elicitation_callback=person) as session:
            tools = (await session.list_tools()).tools
            assert {one.name for one in tools} == TOOLS
            assert sum(
                len(one.model_dump_json(exclude_none=True, exclude={"output_schema"})) for one in tools
            ) < 510 * len(TOOLS)
            assert sum(len(json.dumps(one.output_schema, separators=(",", ":"))) for one in tools) < 960 * len(TOOLS)
            fields = [field for one in tools for field in one.input_schema["properties"].values()]
            assert all(field.get("description") for field in fields)
            found = await session.call_tool("find_devices", {"query": "light"})
            assert len(found.content[0].text) < FOUR_LAMPS
            assert (await call(session, "command", device="lamp1", do="on"))["outcome"] == "confirmed"
            assert "lamp1 reported on" in str(await call(session, "why", device="lamp1"))
            nosuch = await session.call_tool("why", {"device": "../nosuch"})
            assert (nosuch.is_error, json.loads(nosuch.content[0].text)["outcome"]) == (True, "not_found")

            await check_proposal(session, api)
            await api.until("/api/habits", lambda found: "habits" in found)  # the history begins after the start
            for tool in ("home", "scenes", "habits", "find_devices"):
                assert "outcome" not in await call(session, tool)
            assert (await call(session, "history", device="lamp1"))["series"]
            assert (await call(session, "achieve", goal="lamp2 on", dry_run=True))["text"]
            no_scene = await session.call_tool("apply_scene", {"scene": "nosuch"})
            assert (no_scene.is_error, no_scene.structured_content) == (True, None)
            declined = await session.call_tool("command", {"device": "front_door", "do": "unlock"})
            assert (declined.is_error, declined.structured_content) == (True, None)
            assert json.loads(declined.content[0].text) == {
                "outcome": "refused",
                "reason": "this device always asks, and no person confirmed the command",
            }
            assert (await call(session, "command", device="front_door", do="unlock"))["outcome"] == "confirmed"
            assert asked == ["locks/front_door: unlock? It always asks: it is a door lock."] * 2

        async with client("keys") as session, api.answering(False) as questions:  # one that can ask nobody
            refused = await call(session, "command", device="front_door", do="lock")
        assert (refused["outcome"], refused["reason"]) == ("refused", "client:local said no")
        assert questions == ["the client keys wants: locks/front_door → locked"]


@pytest.mark.parametrize("mode", ["auto", "legacy"])
async def test_an_agent_over_http_may_do_what_its_token_may_and_its_session_outlives_a_connection(
    tmp_path: Path, mode: str
) -> None:
    """The older protocol has sessions; for its clients the house is asked, as answers at the door are no streams."""
    mcp: Any = pytest.importorskip("mcp.client.client")
    http: Any = pytest.importorskip("mcp.client.streamable_http")
    httpx2: Any = pytest.importorskip("httpx2")
    types: Any = pytest.importorskip("mcp.types")
    asked: list[str] = []
    routine = 'name = "Of {}"\nwhen = ["lamp1 on"]\ndo = ["lamp2 off"]\n'

    async def person(_: object, question: Any) -> Any:
        asked.append(question.message)
        return types.ElicitResult(action="accept", content={"confirm": True})

    async def outcomes(session: Any, name: str) -> list[str]:
        calls: list[tuple[str, dict[str, object]]] = [
            ("home", {}),
            ("command", {"device": "lamp1", "do": "on"}),
            ("command", {"device": "front_door", "do": "unlock"}),
            ("propose_routine", {"text": routine.format(name)}),
            ("explain_routine", {"name": f"of {name}"}),
            ("try_routine", {"text": routine.format(name)}),
            ("identify", {"devices": "light", "sensor": "/nothing", "at_night": True}),
        ]
        answers = [json.loads((await session.call_tool(*call)).content[0].text) for call in calls]
        return [str(one.get("outcome") or one.get("text") or "done") for one in answers]

    async with running_api(tmp_path, **HISTORY) as api:
        questions: list[str] = []
        url, found, trials = f"http://127.0.0.1:{api.port}/mcp", dict[str, list[str]](), dict[str, str]()
        for name in ("reader", "agent", "manager"):
            client = httpx2.AsyncClient(headers={"Authorization": bearer(name)}, timeout=PATIENCE, trust_env=False)
            over = http.streamable_http_client(url, http_client=client)
            in_house = (True,) if mode == "legacy" and name == "manager" else ()
            session_of = mcp.Client(over, mode=mode, elicitation_callback=person)
            async with client, session_of as session, api.answering(*in_house) as asked_there:
                assert {one.name for one in (await session.list_tools()).tools} == TOOLS
                found[name] = await outcomes(session, name)
                of_sun = routine.format("sun").replace("lamp1 on", "sunset")
                trials[name] = "\n".join(await trial_of(session, of_sun))
            questions += asked_there
        none, proposed = "refused", "proposed Of {0}; the owner enables it: homebot routine enable 'Of {0}'"
        assert found["reader"] == ["done", none, none, none, "not_found", "done", none]
        assert [one.partition(" ")[0] for one in found["agent"]] == [
            *("done", "confirmed", none, "proposed", "done", "done", "done"),
        ]
        assert "the right act is missing" in trials["reader"], "it may not know the place"
        assert "set latitude" in trials["agent"], "the home has none"
        assert "routines.toml" not in trials["agent"], "a temporary file"
        assert found["manager"][2:4] == ["confirmed", proposed.format("manager")]
        assert (len(asked), len(questions)) == ((3, 0) if mode == "auto" else (0, 1))

        hello = {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": {"name": "raw", "version": "1"}}
        first = {"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": hello}
        listed = {"jsonrpc": "2.0", "id": 2, "method": "tools/list"}
        accepted = {"Accept": "application/json, text/event-stream"}

        async def posted(message: object, name: str, **headers: str) -> Any:
            given = (
                accepted | {"Authorization": bearer(name)} | {key.replace("_", "-"): headers[key] for key in headers}
            )
            async with httpx2.AsyncClient(headers=given, trust_env=False) as connection:
                return await connection.post(url, json=message)

        begun = (await posted(first, "agent")).headers["mcp-session-id"]
        assert "find_devices" in (await posted(listed, "agent", Mcp_Session_Id=begun)).text
        assert (await posted(listed, "manager", Mcp_Session_Id=begun)).status_code == 404, "it is another's"
        assert (await posted(first, "agent", Origin="http://evil.example")).status_code == 403
        assert (await posted(first, "agent", Authorization="Bearer wrong")).status_code == 401
        async with httpx2.AsyncClient(headers={"Authorization": bearer("agent")}, trust_env=False) as connection:
            stream = await connection.get(url)
        assert (stream.status_code, stream.headers["allow"]) == (405, "DELETE, POST")


async def test_the_session_that_was_idle_for_longest_gives_way_to_a_new_one(tmp_path: Path) -> None:
    """Many clients begin one for each conversation, and end none."""
    httpx2: Any = pytest.importorskip("httpx2")
    hello = {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": {"name": "raw", "version": "1"}}
    first = {"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": hello}
    listed = {"jsonrpc": "2.0", "id": 2, "method": "tools/list"}
    given = {"Accept": "application/json, text/event-stream", "Authorization": bearer("agent")}
    async with (
        running_api(tmp_path) as api,
        httpx2.AsyncClient(headers=given, timeout=PATIENCE, trust_env=False) as connection,
    ):

        async def status(message: object, session: str) -> int:
            headers = {"Mcp-Session-Id": session}
            answer = await connection.post(f"http://127.0.0.1:{api.port}/mcp", json=message, headers=headers)
            return int(answer.status_code)

        async def begin() -> str:
            answer = await connection.post(f"http://127.0.0.1:{api.port}/mcp", json=first)
            assert answer.status_code == 200, answer.text
            return str(answer.headers["mcp-session-id"])

        sessions = [await begin() for _ in range(16)]
        assert await status(listed, sessions[0]) == 200
        sessions += [await begin() for _ in range(40)]
        alive = [number for number, session in enumerate(sessions) if await status(listed, session) == 200]
        assert alive == list(range(40, 56))
        assert await status(listed, sessions[40]) == 200
        sessions.append(await begin())
        assert await status(listed, sessions[40]) == 200
        assert await status(listed, sessions[41]) == 404


@pytest.mark.parametrize("mode", ["auto", "legacy"])
async def test_the_device_that_a_person_agreed_to_is_commanded_and_not_one_that_was_renamed_since(mode: str) -> None:
    mcp: Any = pytest.importorskip("mcp.client.client")
    server: Any = pytest.importorskip("homebot.bridges.home_api.agent_server")
    types: Any = pytest.importorskip("mcp.types")
    called = ["shed", "front_door", "front_door"]
    asked: list[str] = []

    class RenamedDevices:
        is_of_house = False

        async def read(self, *_: str) -> str:
            return json.dumps({"id": called[len(asked)], "always_asks": "it is a lock"})

        async def post(self, _path: str, body: dict[str, object]) -> str:
            return outcome_of(body)

    async def person(_: object, question: Any) -> Any:
        asked.append(question.message)
        return types.ElicitResult(action="accept", content={"confirm": True})

    async with mcp.Client(server.house_server(RenamedDevices()), mode=mode, elicitation_callback=person) as session:
        result = await session.call_tool("command", {"device": "Door#bolt", "do": "unlock\x1b[2K\n"})
    commanded = json.loads(result.structured_content["text"])["device"]
    assert commanded.endswith("#bolt")
    assert asked[-1].startswith(f"{commanded}: unlock\\x1b[2K\\n?")  # nothing overwrites the question


async def test_nothing_is_sent_to_a_device_that_cannot_be_looked_up() -> None:
    """It might be one that always asks, and the directory may answer the command again."""
    mcp: Any = pytest.importorskip("mcp.client.client")
    server: Any = pytest.importorskip("homebot.bridges.home_api.agent_server")
    problem = {"outcome": "failed", "reason": "discovery does not answer"}

    class NoDirectory:
        async def read(self, *_: str) -> str:
            raise server.AgentMistakeError(*problem.values())

        async def post(self, path: str, _body: object) -> str:
            raise AssertionError(path)

    async with mcp.Client(server.house_server(NoDirectory())) as session:
        result = await session.call_tool("command", {"device": "front_door", "do": "unlock"})
    assert (result.is_error, json.loads(result.content[0].text)) == (True, problem)


MISTAKES: tuple[tuple[str, dict[str, object], str], ...] = (
    ("find_devices", {"limit": 500}, "limit: Input should be less than or equal to 200; it takes query, limit"),
    ("find_devices", {"query": "light and"}, "a term is missing next to 'and'"),
    ("why", {"device": "x" * 501}, "device: String should have at most 500 characters; it takes device, state"),
    ("why", {"device": "lmp1"}, "no device fits 'lmp1'; did you mean lamp1?"),
    ("command", {"device": "", "do": "on"}, "device: is empty; it takes device, do"),
    ("command", {"device": [], "do": "on"}, "device: is empty"),
    ("command", {"device": "lamp1"}, "do: Field required; it takes device, do"),
    ("command", {"device": "lamp1", "do": ""}, "do: is empty"),
    ("command", {"device": ["lamp1", "nope"], "do": "on"}, "no device fits 'nope'"),
    ("history", {"device": "lamp1", "since": "soon"}, "since: 'soon' is not a duration"),
    ("history", {"device": "lamp1", "points": 0}, "points: Input should be greater than or equal to 1"),
    ("apply_scene", {"scene": "Film", "transition": -1}, "transition: Input should be greater than or equal to 0"),
    ("apply_scene", {"scene": "Flim"}, "there is no scene 'Flim'; did you mean Film?"),
    ("identify", {"devices": "", "sensor": "x"}, "devices: is empty"),
    ("propose_routine", {"text": ""}, "text: is empty"),
    ("achieve", {"goal": ""}, "goal: is empty"),
    ("comand", {}, "there is no tool 'comand'; did you mean command?"),
)


async def test_a_mistake_names_the_tools_own_argument_and_commands_are_read_as_over_http(tmp_path: Path) -> None:
    mcp: Any = pytest.importorskip("mcp.client.client")
    server: Any = pytest.importorskip("homebot.bridges.home_api.agent_server")
    words = ("on, 40 %", "+10 %", "60 %, over 3s", "off, over 2s", "40%", "brighter")
    async with running_api(tmp_path, **HISTORY) as api:
        await api.save("Film", {"lamp1": "20 %"})
        address = ServerAddress("127.0.0.1", api.port, TOKENS["keys"][0])
        client = await anyio.to_thread.run_sync(importlib.import_module("homebot.cli.mcp_server").ApiClient, address)
        async with mcp.Client(server.house_server(client)) as session:
            for tool, given, problem in MISTAKES:
                told = await session.call_tool(tool, given)
                answer = json.loads(told.content[0].text)
                assert (told.is_error, answer["outcome"] in {"invalid", "not_found"}) == (True, True), answer
                assert answer["reason"].startswith(problem), answer
            for do in words:
                over_mcp = (await session.call_tool("command", {"device": "lamp1", "do": do})).structured_content
                over_http = (await api.command("lamp2", do)).values
                assert over_mcp["outcome"] == over_http["outcome"] == "confirmed", (over_mcp, over_http)
                texts = {over_mcp["text"].partition("; ")[2], over_http["text"].partition("; ")[2]}
                assert texts == {"it takes no transition" if "over" in do else ""}
            values = [(await api.get(f"/api/devices/{name}")).values for name in ("lamp1", "lamp2")]
            assert values[0]["level"] == values[1]["level"]
            scene = (await session.call_tool("apply_scene", {"scene": "Film", "transition": 3})).structured_content
            assert scene["text"].endswith("; it takes no transition")


async def test_an_unknown_argument_is_refused_with_the_nearest_one() -> None:
    """Ignored, a misspelt query would list everything, and a misspelt room command every lamp."""
    mcp: Any = pytest.importorskip("mcp.client.client")
    server: Any = pytest.importorskip("homebot.bridges.home_api.agent_server")

    class Unasked:
        async def read(self, *asked: str) -> str:
            raise AssertionError(asked)

        post = read

    async with mcp.Client(server.house_server(Unasked())) as session:
        misspelt = await session.call_tool("find_devices", {"querry": "lamp"})
        strange = await session.call_tool("home", {"x" * 500: 1})
        tools = (await session.list_tools()).tools
    assert [one.name for one in tools if (one.output_schema or {}).get("type") != "object"] == []
    assert (misspelt.is_error, strange.is_error) == (True, True)
    assert json.loads(misspelt.content[0].text) == {
        "outcome": "invalid",
        "reason": "find_devices has no argument 'querry'; did you mean query?",
    }
    assert json.loads(strange.content[0].text)["reason"].endswith("it takes none")
    assert len(strange.content[0].text) < 200


async def test_one_command_is_for_several_devices_of_which_a_person_is_asked_about_those_that_always_ask() -> None:
    mcp: Any = pytest.importorskip("mcp.client.client")
    server: Any = pytest.importorskip("homebot.bridges.home_api.agent_server")
    types: Any = pytest.importorskip("mcp.types")
    asked: list[str] = []

    class Devices:
        is_of_house = False

        async def read(self, _: str, name: str) -> str:
            return json.dumps({"id": f"id-{name}", **({"always_asks": "it is a lock"} if "door" in name else {})})

        async def post(self, _: str, body: dict[str, object]) -> str:
            return outcome_of(body)

    async def person(_: object, question: Any) -> Any:
        asked.append(question.message)
        return types.ElicitResult(action="accept", content={"confirm": True})

    async with mcp.Client(server.house_server(Devices()), elicitation_callback=person) as session:
        lamps = await session.call_tool("command", {"device": ["lamp1", "lamp2#left"], "do": "off"})
        assert json.loads(lamps.structured_content["text"]) == {
            "device": ["id-lamp1", "id-lamp2#left"],
            "do": "off",
            "ask": False,
        }
        assert not asked
        await session.call_tool("command", {"device": ["lamp1", "door"], "do": "lock"})
    assert set(asked) == {"id-door: lock? It always asks: it is a lock."}


async def test_raw_json_rpc_is_refused_what_its_token_has_no_right_to_and_hears_why(tmp_path: Path) -> None:
    pytest.importorskip("mcp")
    client = {"name": "raw", "version": "1"}
    hello = {"protocolVersion": "2025-06-18", "capabilities": {"elicitation": {}}, "clientInfo": client}
    async with running_api(tmp_path, **HISTORY) as api:
        process = await anyio.open_process([sys.executable, *arguments(api, tmp_path, "agent")], stderr=None)
        async with process:
            assert process.stdin is not None
            assert process.stdout is not None
            sent, lines = process.stdin, BufferedByteReceiveStream(process.stdout)

            async def send(**message: object) -> None:
                await sent.send(json.dumps({"jsonrpc": "2.0", **message}).encode() + b"\n")

            async def received() -> Any:
                with anyio.fail_after(PATIENCE):
                    return json.loads(await lines.receive_until(b"\n", 100_000))

            await send(id=1, method="initialize", params=hello)
            assert (await received())["result"]["serverInfo"]["name"] == "homebot"
            await send(method="notifications/initialized")
            await send(id=2, method="tools/list")
            assert {one["name"] for one in (await received())["result"]["tools"]} == TOOLS
            unlock = {"name": "command", "arguments": {"device": "front_door", "do": "unlock"}}
            await send(id=3, method="tools/call", params=unlock)
            question = await received()
            assert question["method"] == "elicitation/create"
            await send(id=question["id"], result={"action": "accept", "content": {"confirm": True}})
            (answer,) = (await received())["result"]["content"]
            refused = json.loads(answer["text"])
            assert refused["outcome"] == "refused"
            assert "such a device needs a right that names it" in refused["reason"]
            await sent.aclose()
            with anyio.fail_after(PATIENCE):
                assert await process.wait() == 0


async def test_it_hears_and_ends_while_all_calls_wait_for_an_answer() -> None:
    pytest.importorskip("mcp")
    waiting = anyio.Event()

    async def answer_nothing(stream: SocketStream) -> None:
        async with stream:
            waiting.set()
            await anyio.sleep_forever()

    async with await anyio.create_tcp_listener(local_host="127.0.0.1") as silent, anyio.create_task_group() as tasks:
        tasks.start_soon(silent.serve, answer_nothing)
        door = f"127.0.0.1:{silent.extra(SocketAttribute.local_port)}"  # noqa: S610 - not Django's
        command = [sys.executable, "-m", "homebot", "mcp", "--door", door]
        async with await anyio.open_process(command, stderr=None) as process:
            assert process.stdin is not None
            assert process.stdout is not None
            lines = BufferedByteReceiveStream(process.stdout)
            client = {
                "protocolVersion": "2025-06-18",
                "capabilities": {},
                "clientInfo": {"name": "raw", "version": "1"},
            }
            messages: list[dict[str, object]] = [
                {"id": "hello", "method": "initialize", "params": client},
                {"method": "notifications/initialized"},
                *({"id": number, "method": "tools/call", "params": {"name": "home"}} for number in range(100)),
                {"id": "ping", "method": "ping"},
            ]
            for message in messages:
                await process.stdin.send(json.dumps({"jsonrpc": "2.0", **message}).encode() + b"\n")
            with anyio.fail_after(PATIENCE):
                await waiting.wait()
                answered = [json.loads(await lines.receive_until(b"\n", 100_000))["id"] for _ in range(2)]
                assert answered == ["hello", "ping"]
                await process.stdin.aclose()
                assert await process.wait() == 0
        tasks.cancel_scope.cancel()
