"""The main job: sweep, choice, map, missions, results; it can be resumed."""
