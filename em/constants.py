"""Physical constants, SI."""

SPEED_OF_LIGHT_M_PER_S = 299_792_458.0
"""Speed of light in vacuum [m/s], exact."""

VACUUM_PERMITTIVITY_F_PER_M = 8.8541878188e-12
"""Electric constant [F/m], CODATA 2022."""

BOLTZMANN_J_PER_K = 1.380649e-23
"""Boltzmann constant [J/K], exact."""
