"""A study that every verb can compute in a second; its last table is ``[mission]``."""

SMALL = """
name = "small"
[room]
box_m = [4.0, 4.0, 3.0]
material = "concrete"
[[tag]]
id = "A"
position_m = [1.0, 3.0, 2.9]
[reader]
response = "isolated"
antennas = 4
[solver]
max_reflections = 1
[map]
spacing_m = 1.0
[mission]
start_m = [3.0, 1.0]
tags = ["A"]
"""
