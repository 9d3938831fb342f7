"""The robot that carries a study's reader, among the walls and objects of a room."""

from octant.geometries.scene import Scene
from octant.navigation.robot.floor import RobotSpace, footprint
from octant.reader_design.study_file.reader import Reader


def robot_space(scene: Scene, reader: Reader, *, radius_m: float, height_m: float) -> RobotSpace:
    """Return where a robot with the reader on top can stand in a room.

    Parameters
    ----------
    scene : The room [m].
    reader : The table ``[reader]``: its ground plane counts where it reaches beyond the robot.
    radius_m, height_m : The robot's round body [m].
    """
    radius_m = max(radius_m, 0.5 * reader.ground_plane_m)
    height_m = max(height_m, reader.height_m)
    return RobotSpace(
        footprint=footprint(scene, radius_m=radius_m, height_m=height_m),
        scene=scene,
        height_m=height_m,
    )
