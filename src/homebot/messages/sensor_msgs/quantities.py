"""ROS ``sensor_msgs`` of one quantity each, and of batteries."""

from homebot.messages.message import Float32, Float32Array, Message, UInt8
from homebot.messages.std_msgs.header import Header

__all__ = ["BatteryState", "FluidPressure", "Illuminance", "RelativeHumidity", "Temperature"]


class Temperature(Message, ros_type="sensor_msgs/msg/Temperature"):
    """A temperature.

    Attributes:
        temperature: Degrees Celsius.
        variance: Its variance; 0 is unknown.
    """

    header: Header
    temperature: float
    variance: float


class RelativeHumidity(Message, ros_type="sensor_msgs/msg/RelativeHumidity"):
    """The humidity of air.

    Attributes:
        relative_humidity: From 0 to 1.
        variance: Its variance; 0 is unknown.
    """

    header: Header
    relative_humidity: float
    variance: float


class Illuminance(Message, ros_type="sensor_msgs/msg/Illuminance"):
    """The brightness of a place.

    Attributes:
        illuminance: Lux.
        variance: Its variance; 0 is unknown.
    """

    header: Header
    illuminance: float
    variance: float


class FluidPressure(Message, ros_type="sensor_msgs/msg/FluidPressure"):
    """The pressure of air or water.

    Attributes:
        fluid_pressure: Pascals.
        variance: Its variance; 0 is unknown.
    """

    header: Header
    fluid_pressure: float
    variance: float


class BatteryState(Message, ros_type="sensor_msgs/msg/BatteryState"):
    """The state of a battery; NaN where a number is unknown.

    Attributes:
        voltage: Volts.
        temperature: Degrees Celsius.
        current: Amperes; negative while it is discharged.
        charge: Ampere hours in it.
        capacity: Ampere hours in it when it was full last.
        design_capacity: Ampere hours in it when it was new.
        percentage: From 0 to 1.
        power_supply_status: 0 unknown, 1 charging, 2 discharging, 3 not charging, 4 full.
        power_supply_health: 0 unknown, 1 good, 2 overheated, 3 dead, 4 overvoltage, 5 another failure, 6 cold,
            7 and 8 a timer expired.
        power_supply_technology: 0 unknown, 1 NiMH, 2 Li-ion, 3 LiPo, 4 LiFe, 5 NiCd, 6 LiMn.
        cell_voltage: Of each cell; may be empty.
        cell_temperature: Of each cell; may be empty.
    """

    header: Header
    voltage: Float32
    temperature: Float32
    current: Float32
    charge: Float32
    capacity: Float32
    design_capacity: Float32
    percentage: Float32
    power_supply_status: UInt8
    power_supply_health: UInt8
    power_supply_technology: UInt8
    present: bool
    cell_voltage: Float32Array
    cell_temperature: Float32Array
    location: str
    serial_number: str
