"""homebot: the home runtime for robots.

An app imports from here: ``from homebot import App, Light, run``. Test helpers are in :mod:`homebot.testing`, ROS's
standard messages in :mod:`homebot.messages`. Each name is imported on first use. The names in this module
are stable, of those below the ones that docs/reference/stable.md lists.
"""

TYPE_CHECKING = False  # typing.TYPE_CHECKING would import typing
if TYPE_CHECKING:
    from homebot.apps import App as App
    from homebot.cli.script import run as run
    from homebot.config import Config as Config
    from homebot.config import load_config as load_config
    from homebot.config import parse_config as parse_config
    from homebot.devices import Device as Device
    from homebot.devices import DeviceChange as DeviceChange
    from homebot.devices import DevicePart as DevicePart
    from homebot.devices import Devices as Devices
    from homebot.devices import Follow as Follow
    from homebot.devices import RawMessage as RawMessage
    from homebot.devices import State as State
    from homebot.devices import StateChange as StateChange
    from homebot.devices.exposure import ExposedDevice as ExposedDevice
    from homebot.devices.handles import AirConditioner as AirConditioner
    from homebot.devices.handles import AlarmPanel as AlarmPanel
    from homebot.devices.handles import Closure as Closure
    from homebot.devices.handles import ContactSensor as ContactSensor
    from homebot.devices.handles import DoorLock as DoorLock
    from homebot.devices.handles import ElectricalMeter as ElectricalMeter
    from homebot.devices.handles import Fan as Fan
    from homebot.devices.handles import FollowHandles as FollowHandles
    from homebot.devices.handles import Handle as Handle
    from homebot.devices.handles import HandleChange as HandleChange
    from homebot.devices.handles import HumiditySensor as HumiditySensor
    from homebot.devices.handles import LawnMower as LawnMower
    from homebot.devices.handles import Light as Light
    from homebot.devices.handles import LightSensor as LightSensor
    from homebot.devices.handles import MediaPlayer as MediaPlayer
    from homebot.devices.handles import OccupancySensor as OccupancySensor
    from homebot.devices.handles import Plug as Plug
    from homebot.devices.handles import PressureSensor as PressureSensor
    from homebot.devices.handles import RoboticVacuumCleaner as RoboticVacuumCleaner
    from homebot.devices.handles import Siren as Siren
    from homebot.devices.handles import SmokeAlarm as SmokeAlarm
    from homebot.devices.handles import Switch as Switch
    from homebot.devices.handles import TemperatureSensor as TemperatureSensor
    from homebot.devices.handles import Thermostat as Thermostat
    from homebot.devices.handles import WaterLeakDetector as WaterLeakDetector
    from homebot.devices.handles import WaterValve as WaterValve
    from homebot.devices.handles import WindowCovering as WindowCovering
    from homebot.devices.outcomes import AlreadySo as AlreadySo
    from homebot.devices.outcomes import Confirmed as Confirmed
    from homebot.devices.outcomes import Contradicted as Contradicted
    from homebot.devices.outcomes import Evidence as Evidence
    from homebot.devices.outcomes import Gone as Gone
    from homebot.devices.outcomes import NoAnswer as NoAnswer
    from homebot.devices.outcomes import Outcome as Outcome
    from homebot.devices.outcomes import Refused as Refused
    from homebot.devices.outcomes import Reverted as Reverted
    from homebot.devices.outcomes import Superseded as Superseded
    from homebot.devices.part import Capability as Capability
    from homebot.devices.part import Part as Part
    from homebot.errors import ClosedError as ClosedError
    from homebot.errors import ConfigError as ConfigError
    from homebot.errors import HomebotError as HomebotError
    from homebot.errors import LinkError as LinkError
    from homebot.errors import PeerError as PeerError
    from homebot.errors import RefusedError as RefusedError
    from homebot.errors import ServiceError as ServiceError
    from homebot.errors import ServiceFailedError as ServiceFailedError
    from homebot.errors import ServiceGoneError as ServiceGoneError
    from homebot.errors import ServiceTimeoutError as ServiceTimeoutError
    from homebot.errors import ServiceUnavailableError as ServiceUnavailableError
    from homebot.errors import UsageError as UsageError
    from homebot.errors import WrongCodeError as WrongCodeError
    from homebot.graph import Client as Client
    from homebot.graph import DurabilityPolicy as DurabilityPolicy
    from homebot.graph import Graph as Graph
    from homebot.graph import HistoryPolicy as HistoryPolicy
    from homebot.graph import LivelinessPolicy as LivelinessPolicy
    from homebot.graph import Node as Node
    from homebot.graph import Publisher as Publisher
    from homebot.graph import QoSProfile as QoSProfile
    from homebot.graph import ReliabilityPolicy as ReliabilityPolicy
    from homebot.graph import Service as Service
    from homebot.graph import Subscription as Subscription
    from homebot.graph import Timer as Timer
    from homebot.graph import qos_profile_default as qos_profile_default
    from homebot.graph import qos_profile_latched as qos_profile_latched
    from homebot.graph import qos_profile_sensor_data as qos_profile_sensor_data
    from homebot.log import configure_logging as configure_logging
    from homebot.messages import Message as Message
    from homebot.messages import ServiceType as ServiceType
    from homebot.runtime import Runtime as Runtime
    from homebot.version import __version__ as __version__

_NAMES = {
    "homebot.apps": "App",
    "homebot.cli.script": "run",
    "homebot.config": "Config load_config parse_config",
    "homebot.devices": """
        Device DeviceChange DevicePart Devices Follow RawMessage State StateChange
        """,
    "homebot.devices.handles": """
        AirConditioner AlarmPanel Closure ContactSensor DoorLock ElectricalMeter Fan FollowHandles Handle HandleChange
        HumiditySensor LawnMower Light LightSensor MediaPlayer OccupancySensor Plug PressureSensor RoboticVacuumCleaner
        Siren SmokeAlarm Switch TemperatureSensor Thermostat WaterLeakDetector WaterValve WindowCovering
        """,
    "homebot.devices.exposure": "ExposedDevice",
    "homebot.devices.outcomes": """
        AlreadySo Confirmed Contradicted Evidence Gone NoAnswer Outcome Refused Reverted Superseded
        """,
    "homebot.devices.part": "Capability Part",
    "homebot.errors": """
        ClosedError ConfigError HomebotError LinkError PeerError RefusedError ServiceError ServiceFailedError
        ServiceGoneError ServiceTimeoutError ServiceUnavailableError UsageError WrongCodeError
        """,
    "homebot.graph": """
        Client DurabilityPolicy Graph HistoryPolicy LivelinessPolicy Node Publisher QoSProfile ReliabilityPolicy
        Service Subscription Timer qos_profile_default qos_profile_latched qos_profile_sensor_data
        """,
    "homebot.log": "configure_logging",
    "homebot.messages": "Message ServiceType",
    "homebot.runtime": "Runtime",
    "homebot.version": "__version__",
}

__all__ = [name for names in _NAMES.values() for name in names.split()]

if not TYPE_CHECKING:  # else a type checker would accept any name

    def __getattr__(name: str) -> object:
        from homebot.support.lazy_names import lazy_names  # noqa: PLC0415 - on first use

        return lazy_names(__name__, _NAMES)(name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
