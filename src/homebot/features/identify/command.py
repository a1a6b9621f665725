"""``homebot identify`` and ``homebot verify``."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Final, cast

from homebot.cli.arguments import duration, set_client_command
from homebot.cli.device_json import json_text
from homebot.cli.door_client import DoorClient, with_client
from homebot.cli.goals import perform_goal
from homebot.devices.wording.json_message import JsonMessage
from homebot.errors import PeerError
from homebot.features.identify import IDENTIFY_DEVICE
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.features.identify.messages import IdentifyDeviceFeedback, IdentifyDeviceResult

_EXAMPLES = """\
  homebot identify 'lights in hall' --with /rosie/light
  homebot identify 'lights in hall' --with /rosie/image --region 200,120,80,80
  homebot identify 'lamp 5 or lamp 6 or lamp 7' --with 'Hall light sensor'

The candidates change all together, each in its own code, never three times in a second; the sensor has to see only one
of them well. Then all are as before. Exit code 0 means that the answer is sure, also if it is none of them; 1 that it
is not.
"""
_VERIFY_EXAMPLES = """\
  homebot verify 'Hall lamp' --with /rosie/light

Exit code 0 means that this is the device that the sensor sees; 1 that it is not, or not surely.
"""
_BARS: Final = "▁▂▃▄▅▆▇█"
_MAX_SHOWN: Final = 3
_MAX_NAME: Final = 30
_WIDEST: Final = 1000
_HALF: Final = 0.5


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_client_command(parser, partial(_identify, is_check=False), _EXAMPLES, acts=True)
    parser.add_argument("candidates", metavar="QUERY", help="the candidates, as for `homebot do`: 1 to 32")
    _add_options(parser)


def add_verify_arguments(parser: argparse.ArgumentParser) -> None:
    set_client_command(parser, partial(_identify, is_check=True), _VERIFY_EXAMPLES, acts=True)
    parser.add_argument("candidates", metavar="DEVICE", help="the id or name of the device")
    _add_options(parser)


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--with",
        dest="topic",
        metavar="TOPIC",
        default="",
        help="a topic with a number or pictures, or a device with a light sensor; default: that in the same room",
    )
    parser.add_argument("--region", metavar="X,Y,W,H", type=_region, default=[], help="of pictures, in pixels")
    parser.add_argument(
        "--least", metavar="NUMBER", type=float, default=0.0, help="the least change by a device in view; default: 5 %%"
    )
    parser.add_argument("--night", action="store_true", help="change devices at night and in quiet hours too")
    parser.add_argument(
        "--seconds",
        metavar="TIME",
        type=partial(duration, least=5, most=600),
        default=60.0,
        help="the time limit, 5 s to 10m; default: 60",
    )
    parser.add_argument("--robot", metavar="NAME", default="", help="the robot of the sensor, to keep the position")
    parser.add_argument("--bearing", metavar="DEGREES", type=float, default=0.0, help="from its heading, to the left")
    parser.add_argument("--distance", metavar="METRES", type=float, default=0.0, help="from the robot")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def _region(text: str) -> list[int]:
    try:
        x, y, width, height = map(int, text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not X,Y,WIDTH,HEIGHT in pixels, such as 200,120,80,80") from None
    return [x, y, width, height]


def _identify(options: argparse.Namespace, *, is_check: bool) -> int:
    goal = {
        "candidates": options.candidates,
        "topic": options.topic,
        "region": options.region,
        "least_effect": options.least,
        "at_night": options.night,
        "seconds": options.seconds,
        "robot": options.robot,
        "bearing": math.radians(options.bearing),
        "distance": options.distance,
    }

    def run(door: DoorClient, _: argparse.Namespace) -> int:
        on_feedback = (lambda _: None) if options.json else _print_look
        values = perform_goal(door, IDENTIFY_DEVICE.name, IDENTIFY_DEVICE.ros_type, goal, on_feedback)
        result = cast("IdentifyDeviceResult", JsonMessage(values))
        if options.json:
            print(json_text(values))
        else:
            if not result.candidates:
                raise PeerError(result.message)
            width = max(len("seen"), *(len(printable(candidate.name, _MAX_NAME)) for candidate in result.candidates))
            print(f"\n{'seen':{width}}  {_sparkline([look.value for look in result.looks])}")
            for place, candidate in enumerate(result.candidates):
                code = "".join("█" if look.levels[place] > _HALF else "·" for look in result.looks)
                effect = f"{candidate.effect:+.3g} ± {candidate.deviation:.2g}"
                print(f"{printable(candidate.name, _MAX_NAME):{width}}  {code}  {candidate.probability:6.1%}  {effect}")
            for left in result.left_out:
                print(f"left out: {printable(left.key)}: {printable(left.value, _WIDEST)}")
            sure = f" ({result.probability:.1%})" if result.success else ""
            print(f"{printable(result.message, _WIDEST)}{sure}")
            if result.at:
                print(f"it is at {printable(result.at)}, which is kept")
        return 0 if result.success and (result.device or not is_check) else 1

    return with_client(options, run)


def _print_look(values: Mapping[str, object]) -> None:
    feedback = cast("IdentifyDeviceFeedback", JsonMessage(values))
    likely = sorted(feedback.candidates, key=lambda candidate: candidate.probability, reverse=True)[:_MAX_SHOWN]
    texts = [f"{printable(candidate.name, _MAX_NAME)} {candidate.probability:.0%}" for candidate in likely]
    look = feedback.look
    print(f"{look.at:5.1f} s  {look.value:8.4g}  {', '.join(texts)}, none {feedback.none:.0%}", flush=True)


def _sparkline(values: Sequence[float]) -> str:
    least, most = min(values), max(values)
    return "".join(_BARS[round((value - least) / ((most - least) or 1.0) * (len(_BARS) - 1))] for value in values)
