"""Programs in rclpy's idioms, run unchanged: six of its tutorials, and the listings of the thesis."""

import os
import re
import signal
import sys
from collections import Counter
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from urllib.parse import urlsplit

import anyio
import pytest
from anyio.streams.text import TextReceiveStream
from tests.patience import PATIENCE

from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions

pytestmark = pytest.mark.slow

PROGRAMS = Path(__file__).parent / "programs"
INTERFACES = PROGRAMS / "interfaces"

PAYLOADS = {
    "home425/lights/roomlights405": b"on",
    "home425/lights/philips165": b"off",
    "home425/window/firstlevel1": b"open",
}
LISTING_8_4 = {
    "/gateway/mqtt/out",
    "/gateway/mqtt/received_data/philips165",
    "/gateway/mqtt/received_data/roomlights405",
    "/gateway/mqtt/received_topics",
    "/parameter_events",
    "/rosout",
}


class Run:
    """Programs at work, and all that they have printed."""

    def __init__(self, process: anyio.abc.Process) -> None:
        assert process.stdout is not None
        self.process = process
        self.text = ""
        self._output = TextReceiveStream(process.stdout)

    async def printed(self, *patterns: str) -> None:
        """Wait until the programs have printed *patterns*, in any order."""
        with anyio.fail_after(PATIENCE):
            while missing := [one for one in patterns if not re.search(one, self.text)]:
                try:
                    self.text += await self._output.receive()
                except anyio.EndOfStream:
                    pytest.fail(f"the programs ended without printing {missing}:\n{self.text}")

    async def exit_code(self) -> int:
        """Wait for the end."""
        with anyio.fail_after(PATIENCE):
            async for text in self._output:
                self.text += text
            return await self.process.wait()


@asynccontextmanager
async def running(*programs: str, arguments: Sequence[str] = (), **environment: str) -> AsyncIterator[Run]:
    command = [sys.executable, "-m", "homebot.compat", "--interfaces", str(INTERFACES)]
    command += [*(str(PROGRAMS / f"{name}.py") for name in programs), "--", *arguments]
    process = await anyio.open_process(command, stderr=-2, env=os.environ | environment)
    async with process:
        try:
            yield Run(process)
        finally:
            if process.returncode is None:
                process.kill()


async def test_a_listener_hears_a_talker_until_ctrl_c() -> None:
    """Each message once and in order; both spins end."""
    async with running("listener", "talker") as run:
        await run.printed(*(f'minimal_subscriber I heard: "Hello World: {number}"' for number in (3, 4, 5)))
        run.process.send_signal(signal.SIGINT)
        assert await run.exit_code() == 130
    heard = [int(one) for one in re.findall(r"heard: \"Hello World: (\d+)", run.text)]
    assert heard == list(range(heard[0], heard[0] + len(heard)))
    assert "Traceback" not in run.text


async def test_a_client_gets_the_sum_from_a_service() -> None:
    """The client starts first, and waits for the service; its shutdown ends the service."""
    async with running("client", "service", arguments=("41", "1")) as run:
        assert await run.exit_code() == 0
    assert "minimal_service Incoming request\\na: 41 b: 1" in run.text
    assert "Result of add_two_ints: for 41 + 1 = 42" in run.text


async def test_a_program_imports_the_modules_beside_it(tmp_path: Path) -> None:
    (tmp_path / "beside.py").write_text("WORD = 'imported'\n")
    (tmp_path / "program.py").write_text("import beside\nprint(beside.WORD)\n")
    async with running(str(tmp_path / "program")) as run:
        assert await run.exit_code() == 0
    assert run.text == "imported\n"


async def test_a_program_may_use_signals_and_an_event_loop_and_ends_with_its_own_code(tmp_path: Path) -> None:
    """The only or last program has the main thread, which they need."""
    text = "import asyncio, signal, sys, rclpy\nsignal.signal(signal.SIGTERM, lambda *_: None)\nrclpy.init()\n"
    (tmp_path / "program.py").write_text(f"{text}print(asyncio.run(asyncio.sleep(0, 'slept')))\nsys.exit(3)\n")
    async with running(str(tmp_path / "program")) as run:
        assert await run.exit_code() == 1
    assert run.text == "slept\n"


async def test_a_program_finds_the_folder_of_its_package_and_fails_for_another(tmp_path: Path) -> None:
    (tmp_path / "package.xml").write_text("<package><name>my_robot</name></package>")
    (tmp_path / "my_robot").mkdir()
    find = "from ament_index_python.packages import get_package_share_directory as find"
    (tmp_path / "my_robot/program.py").write_text(f"{find}\nprint(find('my_robot'))\nfind('another')\n")
    async with running(str(tmp_path / "my_robot/program")) as run:
        assert await run.exit_code() == 1
    assert run.text.startswith(f"{tmp_path}\n")
    assert "another is not below AMENT_PREFIX_PATH, and no package.xml beside or above" in run.text


async def test_a_program_has_not_failed_that_works_when_another_one_shuts_down(tmp_path: Path) -> None:
    begin = "import rclpy\nfrom std_msgs.msg import String\nrclpy.init()\n"
    busy, last = tmp_path / "busy.py", tmp_path / "last.py"
    busy.write_text(
        f"{begin}p = rclpy.create_node('a').create_publisher(String, 't', 1)\nwhile True: p.publish(String())\n"
    )
    last.write_text(f"{begin}n = rclpy.create_node('b')\nwhile not n.count_publishers('t'): pass\nrclpy.shutdown()\n")
    async with running(str(busy.with_suffix("")), str(last.with_suffix(""))) as programs:
        assert (await programs.exit_code(), programs.text) == (0, "")


async def test_a_program_that_uses_the_graph_it_shut_down_fails(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text("import rclpy\nrclpy.init()\nrclpy.shutdown()\nrclpy.create_node('late')\n")
    async with running(str(program.with_suffix(""))) as run:
        assert await run.exit_code() == 1
    assert "rclpy is not initialized; call rclpy.init() first" in run.text


async def test_an_action_reports_feedback_and_a_result_and_can_be_cancelled() -> None:
    """The execution blocks its thread; feedback arrives meanwhile, and so does the request to cancel a second goal."""
    async with running("action_client", "action_server") as run:
        assert await run.exit_code() == 0
    assert "Result: [0, 1, 1, 2, 3, 5, 8, 13, 21, 34, 55] after 9 feedbacks" in run.text
    assert "Goal canceled" in run.text
    assert "fibonacci_action_client Status: 5" in run.text


async def test_a_parameter_is_declared_read_and_set() -> None:
    """The tutorial sets it back after each greeting, and its own check refuses an empty name."""
    async with running("parameters") as run:
        await run.printed("Hello world!", "Hello moon!", "refused: an empty name")


async def test_the_light_service_of_the_thesis_answers_as_in_its_chapter_8(embedded_broker_url: str) -> None:
    """Thirty messages of three devices: each `on` of the one lamp is answered with `off`, and nothing else is sent.

    The topics that exist are those of listing 8.4.
    """
    programs = ("mqtt_gateway", "discovery_manager", "light_service", "witness")
    options = MqttOptions.from_url(embedded_broker_url)
    port = str(urlsplit(embedded_broker_url).port)
    async with MqttConnection(options, AiomqttClient, status_topic=None) as field:
        await field.subscribe(MqttSubscription("home425/+/+/in", qos=1))
        await field.wait_connected()
        async with running(*programs, MQTT_PORT=port) as run:
            await run.printed("mqtt_publisher is connected")
            for device in PAYLOADS:
                await field.publish(f"{device}/out", b"hello", qos=1)
            await run.printed("light_service knows 2 lights")
            for _ in range(10):
                for device, payload in PAYLOADS.items():
                    await field.publish(f"{device}/out", payload, qos=1)
            answers = await heard(field, 10)
            assert answers == {"home425/lights/roomlights405/in off": 10}
            await run.printed(r"(?s)(philips165/out is off.*){10}", r"(?m)^/gateway.*\n")
            topics = [line for line in run.text.splitlines() if line.startswith("/gateway")]
            assert set(topics[-1].split()) == LISTING_8_4


async def heard(field: MqttConnection, expected: int) -> Counter[str]:
    """Return the commands to devices, at least *expected*, with as many more as come within a second."""
    counts: Counter[str] = Counter()
    with anyio.move_on_after(PATIENCE) as scope:
        while True:
            messages = await field.receive()
            counts.update(f"{message.topic} {message.payload.decode()}" for message in messages)
            field.ack(messages)
            if counts.total() >= expected:
                scope.deadline = anyio.current_time() + 1
    return counts
