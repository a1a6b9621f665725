"""Alerts: people are told what is wrong in the house."""
