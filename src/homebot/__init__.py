"""homebot: the home runtime for robots.

An app imports from here: ``from homebot import App, Light, run``. Help for its tests is in
:mod:`homebot.testing`, ROS's standard messages are in :mod:`homebot.messages`. Each name is imported when it is first
asked for. Modules below may change from one release to the next; the names of this one are kept.
"""

TYPE_CHECKING = False  # typing.TYPE_CHECKING would import typing
if TYPE_CHECKING:
    from homebot.apps import App
    from homebot.cli.script import run
    from homebot.config import Config, load_config, parse_config
    from homebot.devices import Device, DeviceChange, DevicePart, Devices, Follow, RawMessage, State, StateChange
    from homebot.devices.exposure import ExposedDevice
    from homebot.devices.handles import (
        AirConditioner,
        AlarmPanel,
        Closure,
        ContactSensor,
        DoorLock,
        ElectricalMeter,
        Fan,
        FollowHandles,
        Handle,
        HandleChange,
        HumiditySensor,
        LawnMower,
        Light,
        LightSensor,
        OccupancySensor,
        Plug,
        PressureSensor,
        RoboticVacuumCleaner,
        Siren,
        SmokeAlarm,
        Switch,
        TemperatureSensor,
        Thermostat,
        WaterLeakDetector,
        WaterValve,
        WindowCovering,
    )
    from homebot.devices.outcomes import (
        AlreadySo,
        Confirmed,
        Contradicted,
        Evidence,
        Gone,
        NoAnswer,
        Outcome,
        Refused,
        Reverted,
        Superseded,
    )
    from homebot.devices.part import Capability, Part
    from homebot.errors import (
        ClosedError,
        ConfigError,
        HomebotError,
        LinkError,
        PeerError,
        RefusedError,
        ServiceError,
        ServiceFailedError,
        ServiceGoneError,
        ServiceTimeoutError,
        ServiceUnavailableError,
        UsageError,
        WrongCodeError,
    )
    from homebot.graph import (
        Client,
        DurabilityPolicy,
        Graph,
        HistoryPolicy,
        LivelinessPolicy,
        Node,
        Publisher,
        QoSProfile,
        ReliabilityPolicy,
        Service,
        Subscription,
        Timer,
        qos_profile_default,
        qos_profile_latched,
        qos_profile_sensor_data,
    )
    from homebot.log import configure_logging
    from homebot.messages import Message, ServiceType
    from homebot.runtime import Runtime
    from homebot.version import __version__

__all__ = [
    "AirConditioner",
    "AlarmPanel",
    "AlreadySo",
    "App",
    "Capability",
    "Client",
    "ClosedError",
    "Closure",
    "Config",
    "ConfigError",
    "Confirmed",
    "ContactSensor",
    "Contradicted",
    "Device",
    "DeviceChange",
    "DevicePart",
    "Devices",
    "DoorLock",
    "DurabilityPolicy",
    "ElectricalMeter",
    "Evidence",
    "ExposedDevice",
    "Fan",
    "Follow",
    "FollowHandles",
    "Gone",
    "Graph",
    "Handle",
    "HandleChange",
    "HistoryPolicy",
    "HomebotError",
    "HumiditySensor",
    "LawnMower",
    "Light",
    "LightSensor",
    "LinkError",
    "LivelinessPolicy",
    "Message",
    "NoAnswer",
    "Node",
    "OccupancySensor",
    "Outcome",
    "Part",
    "PeerError",
    "Plug",
    "PressureSensor",
    "Publisher",
    "QoSProfile",
    "RawMessage",
    "Refused",
    "RefusedError",
    "ReliabilityPolicy",
    "Reverted",
    "RoboticVacuumCleaner",
    "Runtime",
    "Service",
    "ServiceError",
    "ServiceFailedError",
    "ServiceGoneError",
    "ServiceTimeoutError",
    "ServiceType",
    "ServiceUnavailableError",
    "Siren",
    "SmokeAlarm",
    "State",
    "StateChange",
    "Subscription",
    "Superseded",
    "Switch",
    "TemperatureSensor",
    "Thermostat",
    "Timer",
    "UsageError",
    "WaterLeakDetector",
    "WaterValve",
    "WindowCovering",
    "WrongCodeError",
    "__version__",
    "configure_logging",
    "load_config",
    "parse_config",
    "qos_profile_default",
    "qos_profile_latched",
    "qos_profile_sensor_data",
    "run",
]

_NAMES = {
    "homebot.apps": "App",
    "homebot.cli.script": "run",
    "homebot.config": "Config load_config parse_config",
    "homebot.devices": """
        Device DeviceChange DevicePart Devices Follow RawMessage State StateChange
        """,
    "homebot.devices.handles": """
        AirConditioner AlarmPanel Closure ContactSensor DoorLock ElectricalMeter Fan FollowHandles Handle HandleChange
        HumiditySensor LawnMower Light LightSensor OccupancySensor Plug PressureSensor RoboticVacuumCleaner Siren
        SmokeAlarm Switch TemperatureSensor Thermostat WaterLeakDetector WaterValve WindowCovering
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
if not TYPE_CHECKING:  # else a name that does not exist would pass for one

    def __getattr__(name: str) -> object:
        from homebot.support.lazy_names import lazy_names  # noqa: PLC0415 - on first use

        return lazy_names(__name__, _NAMES)(name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
