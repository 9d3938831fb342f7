"""Docking: from across the room to a pose in front of a landmark."""
