"""Simulated Shellys: both generations over MQTT, and the second over HTTP."""
