"""``python -m homebot.compat PROGRAM... [-- ARGUMENT...]``: runs unchanged ROS 2 programs on one graph."""

import argparse
import sys
import threading
import traceback
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from types import ModuleType

from homebot.compat import packages, rclpy, tf2_ros
from homebot.compat.messages import program_type
from homebot.compat.remote import CONTEXT
from homebot.errors import UsageError
from homebot.messages.interfaces import Interfaces
from homebot.messages.interfaces.interface_text import Interface

_MODULES = (
    " .action .callback_groups .client .clock .duration .event_handler .exceptions .executors .guard_condition .impl"
    " .impl.logging_severity .logging .node .parameter .publisher .serialization .service .subscription .task .time"
    " .timer .utilities .wait_for_message"
)
"""The submodules of rclpy, which are all mapped to ours."""

_TF2_MODULES = " .buffer .static_transform_broadcaster .transform_broadcaster .transform_listener"


def main(argv: Sequence[str] | None = None) -> int:
    """Run the programs in *argv*, the last on this thread, as signals and some libraries need it; return the exit code.

    It is 1 if one failed. Ctrl-C ends all of them, and so does ``rclpy.shutdown()`` in one.
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
    words = list(sys.argv[1:] if argv is None else argv)
    end = words.index("--") if "--" in words else len(words)
    options = parser.parse_args(words[:end])
    sys.argv[1:] = words[end + 1 :]
    texts = {key: text for folder in options.interfaces for key, text in Interfaces.read_folder(folder).items()}
    _install_modules(Interfaces(texts))
    failed: list[str] = []
    *others, last = options.programs
    threads = [threading.Thread(target=_run, args=(program, failed), daemon=True) for program in others]
    try:
        with rclpy.init():
            for thread in threads:
                thread.start()
            _run(last, failed)
            for thread in threads:
                thread.join()
    except KeyboardInterrupt:
        return 130
    return 1 if failed else 0


def _install_modules(interfaces: Interfaces) -> None:
    """Make ``rclpy`` and the packages of *interfaces* importable, replacing those of an installed ROS."""
    for name in _MODULES.split(" "):
        sys.modules[f"rclpy{name}"] = rclpy
    sys.modules["rclpy.qos"] = rclpy.qos
    sys.modules["ament_index_python"] = sys.modules["ament_index_python.packages"] = packages
    for name in _TF2_MODULES.split(" "):
        sys.modules[f"tf2_ros{name}"] = tf2_ros
    finders: dict[str, Callable[[str], Interface]] = {
        "msg": interfaces.find_message,
        "srv": interfaces.find_service,
        "action": interfaces.find_action,
    }
    for package in {key.partition("/")[0] for key in interfaces.names()}:
        sys.modules[package] = module = ModuleType(package)
        for kind, find in finders.items():
            sys.modules[f"{package}.{kind}"] = part = ModuleType(f"{package}.{kind}")
            setattr(module, kind, part)
            setattr(part, "__getattr__", partial(_interface, find, f"{package}/{kind}"))  # noqa: B010 - PEP 562


def _interface(find: Callable[[str], Interface], prefix: str, name: str) -> object:
    """Return the interface that a program imports by *name*, loaded on first use."""
    if name.startswith("_"):
        raise AttributeError(name)
    try:
        return program_type(find(f"{prefix}/{name}"))
    except UsageError as exc:
        raise ImportError(str(exc)) from exc


def _run(program: str, failed: list[str]) -> None:
    sys.path.insert(0, str(Path(program).resolve().parent))
    try:
        code = compile(Path(program).read_bytes(), program, "exec")
        exec(code, {"__name__": "__main__", "__file__": program})  # noqa: S102 - the program that was named
    except SystemExit as exc:  # of its last line, as in ROS's tutorials
        failed += [program] if exc.code else []
    except Exception as exc:  # noqa: BLE001 - shown as Python shows the failure of a program
        if isinstance(exc, UsageError) and CONTEXT.is_ended_by_another():
            return
        failed.append(program)
        traceback.print_exc()


if __name__ == "__main__":
    sys.exit(main())
