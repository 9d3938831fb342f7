"""What each antenna of a reader receives over the floor of a room, in W and dBm."""

import octant

room = octant.Room.box((5.0, 4.0, 3.0), "concrete")
tag = octant.Tag("0xFFF9", (2.0, 0.5, 2.95), antenna="dipole")
reader = octant.Reader(antenna_radius_m=0.10, plate_height_m=0.08, response="rays")
rss = room.rss_map([tag], reader, spacing_m=0.5, heading_deg=[0.0, 90.0])
print(rss["rss_dbm"].max("antenna"))
