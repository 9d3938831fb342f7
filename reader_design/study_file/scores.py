"""The scores of a reader design: names, units, and which way is better."""

from dataclasses import asdict, dataclass, fields


@dataclass(frozen=True, slots=True, kw_only=True)
class Scores:
    """The scores of one reader design in one surrounding; shares run from 0 to 1.

    Attributes
    ----------
    right_share : Share of directions [-] for which the strongest antenna is the nearest in angle.
    strongest_mean_rad, strongest_rms_rad, strongest_p90_rad, strongest_max_rad : Error [rad] of the
        bearing "azimuth of the strongest antenna": mean absolute value, root mean square, 90th
        percentile and largest absolute value.
    strongest_median_rad : Its 50th percentile [rad].
    strongest_beyond_45_share, strongest_beyond_90_share : Shares of directions [-] in which it errs
        by more than 45 and 90 degrees.
    vector_mean_rad, vector_rms_rad, vector_p90_rad, vector_max_rad : The same [rad] for the bearing
        of the RSS-weighted vector sum.
    vector_median_rad : Its 50th percentile [rad].
    vector_beyond_45_share, vector_beyond_90_share : Shares of directions [-] in which it errs by
        more than 45 and 90 degrees; beyond 90 the robot is sent away from the tag.
    front_to_back_mean_db, front_to_back_worst_db : RSS of the antenna that faces the tag over that
        of the opposite one [dB].
    margin_mean_db, margin_worst_db : RSS of the antenna that faces the tag over the stronger of its
        two neighbours [dB].
    monotonic_share, monotonic_normalised_share : Share of distances or places [-] at which z2 - z4,
        or (z2 - z4)/(z2 + z4), grows all the way while the tag turns from antenna 4 to antenna 2.
    slope_w_per_rad, slope_normalised_per_rad : Slope of z2 - z4 [W/rad], and of (z2 - z4)/(z2 + z4)
        [1/rad], with the tag straight ahead; median over distances or places; positive is the right
        sign.
    full_scale_w, full_scale_normalised : Largest absolute z2 - z4 [W] and (z2 - z4)/(z2 + z4) [-]
        between antennas 4 and 2; median over distances or places.
    usable_share : Share of samples [-] whose strongest antenna reaches the threshold.
    level_median_dbm, level_p10_dbm : Median and 10th percentile of the strongest antenna's RSS
        [dBm].
    captured_share : Share of places and facing antennas [-] where one reflection brings more power
        than the direct ray; 0 in free space.
    read_right_share, read_strongest_rms_rad : As ``right_share`` [-] and ``strongest_rms_rad``
        [rad], of what the receiver reads.
    read_vector_median_rad, read_vector_rms_rad, read_vector_p90_rad : As the scores of the vector
        sum [rad], of what the receiver reads.
    read_vector_beyond_90_share : As ``vector_beyond_90_share`` [-], of what the receiver reads.
    """

    right_share: float
    strongest_mean_rad: float
    strongest_rms_rad: float
    strongest_p90_rad: float
    strongest_max_rad: float
    strongest_median_rad: float
    strongest_beyond_45_share: float
    strongest_beyond_90_share: float
    vector_mean_rad: float
    vector_rms_rad: float
    vector_p90_rad: float
    vector_max_rad: float
    vector_median_rad: float
    vector_beyond_45_share: float
    vector_beyond_90_share: float
    front_to_back_mean_db: float
    front_to_back_worst_db: float
    margin_mean_db: float
    margin_worst_db: float
    monotonic_share: float
    monotonic_normalised_share: float
    slope_w_per_rad: float
    slope_normalised_per_rad: float
    full_scale_w: float
    full_scale_normalised: float
    usable_share: float
    level_median_dbm: float
    level_p10_dbm: float
    captured_share: float
    read_right_share: float
    read_strongest_rms_rad: float
    read_vector_median_rad: float
    read_vector_rms_rad: float
    read_vector_p90_rad: float
    read_vector_beyond_90_share: float

    def as_dict(self) -> dict[str, float]:
        """Return the scores by name, each in the unit that its name carries [rad, dB, W or -]."""
        return asdict(self)


SCORE_NAMES = tuple(field.name for field in fields(Scores))
"""Names of all scores in their order; the suffix of each is its unit."""


_LESS_IS_BETTER = ("strongest_", "vector_", "captured_", "read_strongest_", "read_vector_")


def higher_is_better(name: str) -> bool:
    """Return whether a score is better when higher: no for errors and for shares that mislead.

    Parameters
    ----------
    name : A name of ``SCORE_NAMES``.
    """
    return not name.startswith(_LESS_IS_BETTER)


def score_unit(name: str) -> str:
    """Return the unit of a score, such as ``dB`` or ``W/rad``; ``1`` for a share.

    Parameters
    ----------
    name : A name of ``SCORE_NAMES``; its suffix says the unit [rad, dB, dBm, W or none].
    """
    for suffix, unit in (
        ("_w_per_rad", "W/rad"),
        ("_per_rad", "1/rad"),
        ("_rad", "rad"),
        ("_dbm", "dBm"),
        ("_db", "dB"),
        ("_w", "W"),
    ):
        if name.endswith(suffix):
            return unit
    return "1"
