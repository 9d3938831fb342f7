"""A first study of a room from its mesh file: what `octant init` writes."""
