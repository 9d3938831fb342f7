"""Antennas as vector far fields: closed forms, tables, pattern files."""
