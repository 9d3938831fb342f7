"""``octant map``: received power over the floor of a room."""
