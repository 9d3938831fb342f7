"""Every path from a tag to a point of a room from a mesh file, and the strongest explained."""

from pathlib import Path

import octant

OFFICE = Path(__file__).parents[1] / "l_shaped_office.glb"

room = octant.Room.load(OFFICE, material="brick", materials={"cabinet": "metal"})
tag = octant.Tag("0xFFF9", (2.0, 0.5, 2.95), antenna="dipole")
paths = room.paths(tx=tag, rx=(1.0, 1.0, 0.3), frequency_hz=2.4e9, max_reflections=2)
print(paths.to_dataframe())
print(paths.explain())
