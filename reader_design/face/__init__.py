"""The Python face: rooms, tags, readers, missions and studies as objects; `octant` shows them."""
