"""A study's rooms: bodies, scene, tags, map grid and plan view."""
