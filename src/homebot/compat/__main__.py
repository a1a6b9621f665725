"""``python -m homebot.compat PROGRAM...``: runs programs written for ROS 2, unchanged, on one graph."""

from __future__ import annotations

import argparse
import sys
import threading
import traceback
from collections.abc import Sequence
from pathlib import Path

from homebot.compat import rclpy
from homebot.compat.ros_imports import install_ros_imports

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the programs that *argv* names, each in a thread of its own, and return the exit code: 1 where one failed.

    Ctrl-C ends all of them, and so does ``rclpy.shutdown()`` in one.
    """
    parser = argparse.ArgumentParser(prog="python -m homebot.compat", description=__doc__)
    parser.add_argument("programs", metavar="PROGRAM", nargs="+", help="a Python file that uses rclpy")
    parser.add_argument(
        "--interfaces",
        metavar="DIR",
        type=Path,
        action="append",
        default=[],
        help="a folder of further interfaces: PACKAGE/msg/NAME.msg and so on; may be given several times",
    )
    options = parser.parse_args(argv)
    programs = options.programs
    install_ros_imports(options.interfaces)
    rclpy.init()
    failed: list[str] = []
    threads = [threading.Thread(target=_run, args=(one, failed), name=one, daemon=True) for one in programs]
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    except KeyboardInterrupt:
        return 130
    finally:
        rclpy.shutdown()
    return 1 if failed else 0


def _run(program: str, failed: list[str]) -> None:
    try:
        code = compile(Path(program).read_bytes(), program, "exec")
        exec(code, {"__name__": "__main__", "__file__": program})  # noqa: S102 - the program that was named
    except Exception:  # noqa: BLE001 - shown as Python shows the failure of a program
        failed.append(program)
        traceback.print_exc()


if __name__ == "__main__":
    sys.exit(main())
