"""Received power: at one antenna, at all antennas of a reader, over a map."""
