"""A navigator of one's own: it drives to where the antennas hear the tag, and past it stops."""

import math

import octant


class Towards(octant.Navigator):
    """Turns to the bearing of all antennas' vector sum; at the tag, when that falls behind."""

    ahead = 0  # readings of this tag in which it was in front

    def step(self, reading: octant.Reading, odometry: octant.Odometry) -> octant.Command:
        """Return what the robot does until the next reading."""
        told, bearing = self.told, reading.bearing_rad(self.told.azimuths_rad)
        speed, in_front = told.cruise_step_m / told.period_s, abs(bearing) < math.radians(60)
        if reading.first:
            self.ahead = 0
        if self.ahead >= 3 and abs(bearing) > math.radians(100):
            return octant.Command(reached=True)
        if odometry.contact:
            return octant.Command(speed_m_per_s=-speed, mode="evade")
        self.ahead += in_front
        turn = 0.5 * bearing / told.period_s
        return octant.Command(speed_m_per_s=speed if in_front else 0.0, turn_rate_rad_per_s=turn)


if __name__ == "__main__":
    tags = [octant.Tag("A", (2.0, 0.5, 2.0)), octant.Tag("B", (3.5, 2.0, 2.0))]
    mission = octant.Mission(
        octant.Room.free_space(),
        tags,
        octant.Reader(response="rays"),
        start=(0.0, 0.0, 90.0),
        navigator=Towards,
    )
    print(*mission.run(10, seed=1, progress=False).lines(), sep="\n")
