"""A reader by itself at two frequencies: impedances, S-matrix and patterns, by full wave."""

import octant

reader = octant.Reader(antenna_radius_m=0.10, plate_height_m=0.08, cells_per_wavelength=6.0)
solved = reader.solve([2.40e9, 2.44e9])
print(solved.z.sel(antenna=1))
print(solved.to_touchstone("reader"), *solved.to_ffe("patterns"))
