"""Logs of received power: what a robot or a person has measured, read from and written to files."""
