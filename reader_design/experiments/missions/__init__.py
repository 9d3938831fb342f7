"""Layouts, links, readers and controllers compared: every combination is driven, once."""
