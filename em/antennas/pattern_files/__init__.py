"""Antenna pattern files of other solvers and of measurements, read and written; S-matrix files."""
