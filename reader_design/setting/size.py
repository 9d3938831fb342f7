"""How large a reader is: what constraints on its size compare."""

from octant.reader_design.setting.design import ReaderDesign


def reader_size_m(design: ReaderDesign, frequency_hz: float) -> tuple[float, float]:
    """Return width and height of a reader above its ground plane [m].

    Parameters
    ----------
    design : ReaderDesign
        The reader.
    frequency_hz : float
        Carrier, at which antennas without a length are resonant [Hz].

    Returns
    -------
    width_m : float
        Side or diameter of the ground plane, or the span of plates or antennas where they reach
        farther [m].
    height_m : float
        Top of the plates or of the antennas, whichever is higher, above the ground plane [m].
    """
    outer_m = design.plate_outer_radius_m or 0.0
    width_m = max(design.ground_plane_m, 2.0 * outer_m, 2.0 * design.antenna_radius_m)
    joined = design.antenna == "monopole" and design.monopole_plane_m == 0.0
    foot_m = 0.0 if joined else design.gap_m
    top_m = foot_m + design.element(frequency_hz).length_m
    height_m = max(top_m, design.plate_height_m, design.plate_height_axis_m or 0.0)
    return width_m, height_m
