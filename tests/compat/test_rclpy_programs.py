"""Programs in rclpy's idioms, run unchanged: six of its tutorials; tests/test_chapter_8.py has the thesis's."""

import os
import re
import signal
import sys
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
from anyio.streams.text import TextReceiveStream
from tests.patience import PATIENCE

pytestmark = pytest.mark.slow

PROGRAMS = Path(__file__).parent / "programs"


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
    command = [sys.executable, "-m", "homebot.compat"]
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
    assert str(tmp_path) in run.text.splitlines()
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
