"""Shakedown limits of rolling contacts."""
