"""sensor_libraries."""
