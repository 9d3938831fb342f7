"""``octant scene``: the room as a GLB file and as a picture."""
