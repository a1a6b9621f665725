import pytest

from homebot.conventions.device_classes import is_quantity, quantity_of
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.device_types import DEVICE_TYPES


@pytest.mark.parametrize(
    ("device_class", "unit", "said", "capability", "value"),
    [
        ("temperature", "°C", 21.5, "temperature", 21.5),
        ("temperature", "°F", 70.7, "temperature", 21.5),
        ("temperature", "℉", 32.0, "temperature", 0.0),
        ("temperature", "K", 293.15, "temperature", 20.0),
        ("humidity", "%", 45.0, "humidity", 45.0),
        ("pressure", "kPa", 101.3, "pressure", 1013.0),
        ("pressure", "Pa", 101_325.0, "pressure", 1013.25),
        ("pressure", "bar", 1.5, "pressure", 1500.0),
        ("pressure", "psi", 14.5037738, "pressure", 1000.0),
        ("atmospheric_pressure", "mbar", 990.0, "pressure", 990.0),
        ("atmospheric_pressure", "mmHg", 760.0, "pressure", 1013.25),
        ("atmospheric_pressure", "inHg", 29.92126, "pressure", 1013.25),
        ("power", "kW", 1.2, "power", 1200.0),
        ("power", "mW", 250.0, "power", 0.25),
        ("energy", "Wh", 1234.0, "energy", 1.234),
        ("energy", "MWh", 0.5, "energy", 500.0),
        ("energy", "MJ", 3.6, "energy", 1.0),
        ("voltage", "mV", 2997.0, "voltage", 2.997),
        ("voltage", "kV", 0.4, "voltage", 400.0),
        ("current", "mA", 16.0, "current", 0.016),
        ("frequency", "kHz", 0.05, "frequency", 50.0),
        ("illuminance", "klx", 1.5, "illuminance", 1500.0),
        ("illuminance", "", 20.0, "illuminance", 20.0),
        ("volume_flow_rate", "L/min", 10.0, "flow", 0.6),
        ("pm25", "μg/m³", 12.0, "pm25", 12.0),
        ("volatile_organic_compounds", "mg/m³", 0.5, "volatile_organic_compounds", 500.0),
        ("battery", "%", 88.0, "battery", 88.0),
        ("moisture", "%", 33.0, "soil_moisture", 33.0),
        ("signal_strength", "dBm", -60.0, "signal_strength", -60.0),
        *[("temperature", unit, 21.5, "temperature", 21.5) for unit in ("° C", "degC", "Celsius")],
        ("humidity", "%RH", 45.0, "humidity", 45.0),
        ("pressure", "mb", 990.0, "pressure", 990.0),
        ("power", "BTU/h", 3412.141633, "power", 1000.0),
        ("", "°F", 70.7, "temperature", 21.5),
        ("", "lx", 20.0, "illuminance", 20.0),
        ("", "kPa", 101.3, "pressure", 1013.0),
        ("", "kW", 1.2, "power", 1200.0),
        ("", "Wh", 1234.0, "energy", 1.234),
        ("", "mV", 2997.0, "voltage", 2.997),
        ("", "mA", 16.0, "current", 0.016),
        ("", "Hz", 50.0, "frequency", 50.0),
        ("", "l/min", 10.0, "flow", 0.6),  # SYR's water softeners
        ("power", "kWh", 12.3, "energy", 12.3),  # HASS_DISCOVER_SENSOR_KWH of Tasmota 8
        ("power", "V", 230.0, "voltage", 230.0),
        ("power", "A", 0.4, "current", 0.4),
        ("energy", "kW", 1.2, "power", 1200.0),  # LIVE_POWER of ecodan-ha-local
    ],
)
def test_a_number_is_reported_in_the_unit_of_the_vocabulary(
    device_class: str, unit: str, said: float, capability: str, value: float
) -> None:
    quantity = quantity_of(device_class, unit)
    assert (quantity.capability, quantity.unit) == (capability, CAPABILITIES[capability].unit)
    assert quantity.value(said) == pytest.approx(value)


@pytest.mark.parametrize(
    ("device_class", "unit", "capability"),
    [
        ("illuminance", "Level", "measurement"),
        ("volatile_organic_compounds_parts", "ppb", "measurement"),
        ("temperature", "°De", "measurement"),
        ("battery", "x", "measurement"),
        ("signal_strength", "dB", "measurement"),
        ("wind_speed", "km/h", "measurement"),
        ("", "lqi", "measurement"),
        ("", "mmHg", "measurement"),  # blood, as of Withings
        ("not_a_class", "furlong", "measurement"),
    ],
)
def test_a_unit_that_cannot_be_converted_stays_and_its_value_is_only_a_measurement(
    device_class: str, unit: str, capability: str
) -> None:
    quantity = quantity_of(device_class, unit)
    assert (quantity.capability, quantity.unit, quantity.value(7.0)) == (capability, unit, 7.0)


@pytest.mark.parametrize(
    ("device_class", "service_type"),
    [
        ("temperature", "temperature_sensor"),
        ("humidity", "humidity_sensor"),
        ("illuminance", "light_sensor"),
        ("pressure", "pressure_sensor"),
        ("energy", "electrical_meter"),
        ("carbon_dioxide", "air_quality_sensor"),
        ("aqi", "air_quality_sensor"),
        ("moisture", "soil_sensor"),
        ("volume_flow_rate", "flow_sensor"),
        ("battery", "x_battery"),
        ("wind_speed", "x_sensor"),
        ("", "x_sensor"),
    ],
)
def test_a_class_names_the_type_of_the_sensor(device_class: str, service_type: str) -> None:
    assert quantity_of(device_class, "").service_type == service_type
    assert service_type in DEVICE_TYPES


def test_a_class_that_we_do_not_know_is_not_taken_for_a_number() -> None:
    assert is_quantity("ph")
    assert not is_quantity("mood")
