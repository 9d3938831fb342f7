"""Meshes, facets and edges, rooms, furniture, the reader's body, occlusion."""
