"""Commands in words: the devices and parts that they mean, and the settings."""
