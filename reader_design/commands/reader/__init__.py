"""``octant reader``: the reader by itself."""
