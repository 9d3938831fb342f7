"""Worlds of the shape of public robot worlds: packages of model folders, written anew, none copied.

As there, a world's models hold an include and a place; meshes are DAE of an FBX exporter, in
centimetres or metres, whose axis Gazebo does not look at, and OBJ; names are model://, package://
and file:// beneath the package; materials, lights and empty poses stand between.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


def boxes(*low_and_size):
    """Corners and outward triangles of boxes, each given by its lowest corner and its size."""
    corners = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    faces = [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]
    vertices = [np.array(low) + corners * np.array(size) for low, size in low_and_size]
    return np.concatenate(vertices), np.concatenate(
        [np.array(faces) + 8 * k for k in range(len(vertices))]
    )


def dae_text(vertices, faces, *, unit_m=1.0, up="Z_UP", node=""):
    """A COLLADA file as FBX exporters write it: '#' and spaces in names, textures that lack."""
    numbers = "\n".join(" ".join(f"{c / unit_m:.6f}" for c in v) for v in vertices)
    index = " ".join(f" {k} 0" for k in faces.reshape(-1))
    material = "Material #946568"
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><contributor><author></author><authoring_tool>FBX COLLADA exporter</authoring_tool>
  </contributor><created>2019-05-15T08:15:48Z</created><keywords></keywords>
  <modified>2019-05-15T08:15:48Z</modified><unit meter="{unit_m:f}" name="u"></unit>
  <up_axis>{up}</up_axis></asset>
  <library_images><image id="Map #1-image" name="Map #1">
    <init_from>../materials/textures/none.png</init_from></image></library_images>
  <library_materials><material id="{material}" name="{material}">
    <instance_effect url="#{material}-fx"/></material></library_materials>
  <library_effects><effect id="{material}-fx" name="{material}"><profile_COMMON>
    <technique sid="standard"><phong><ambient><color sid="ambient">0.5 0.5 0.5 1.0</color></ambient>
    <diffuse><texture texture="Map #1-image" texcoord="CHANNEL0"><extra>
    <technique profile="MAYA"><wrapU sid="wrapU0">TRUE</wrapU></technique></extra></texture>
    </diffuse><transparency><float sid="transparency">0.000000</float></transparency></phong>
    </technique></profile_COMMON></effect></library_effects>
  <library_geometries><geometry id="body-lib" name="bodyMesh"><mesh>
    <source id="body-POSITION"><float_array id="body-POSITION-array" count="{3 * len(vertices)}">
{numbers}
    </float_array><technique_common><accessor source="#body-POSITION-array"
      count="{len(vertices)}" stride="3"><param name="X" type="float"/>
      <param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common>
    </source><source id="body-UV0"><float_array id="body-UV0-array" count="2">0.0 0.0</float_array>
      <technique_common><accessor source="#body-UV0-array" count="1" stride="2">
      <param name="S" type="float"/><param name="T" type="float"/></accessor></technique_common>
    </source>
    <vertices id="body-VERTEX"><input semantic="POSITION" source="#body-POSITION"/></vertices>
    <triangles count="{len(faces)}" material="{material}">
      <input semantic="VERTEX" offset="0" source="#body-VERTEX"/>
      <input semantic="TEXCOORD" offset="1" set="0" source="#body-UV0"/><p>{index}</p></triangles>
    </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="scene" name="scene"><node name="body" id="body"
    sid="body">{node}<instance_geometry url="#body-lib"><bind_material><technique_common>
    <instance_material symbol="{material}" target="#{material}"/></technique_common></bind_material>
    </instance_geometry></node><extra><technique profile="MAX3D"><frame_rate>30</frame_rate>
    </technique></extra></visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#scene"></instance_visual_scene></scene>
</COLLADA>
"""


def obj_text(vertices, faces):
    """An OBJ file with a material library that lacks, groups and normals by number."""
    lines = ["mtllib none.mtl", "o body", *(f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices)]
    lines += ["vn 0 0 1", "usemtl wood", "s off"]
    return "\n".join(lines + [f"f {a + 1}//1 {b + 1}//1 {c + 1}//1" for a, b, c in faces]) + "\n"


@dataclass
class Package:
    """A ROS package of a world in a folder, and its includes so far."""

    folder: Path
    includes: list = field(default_factory=list)

    def model(self, name, mesh, *, kind="DAE", uri="model", models="models", scale=None, **how):
        """Write a model folder with a visual and a collision mesh."""
        at = self.folder / models / name
        (at / "meshes").mkdir(parents=True, exist_ok=True)
        file = f"meshes/{name}_visual.{kind}"
        given = (mesh[0] / (scale or 1.0), mesh[1])
        text = obj_text(*given) if kind == "obj" else dae_text(*given, **how)
        (at / file).write_text(text)
        begin = {
            "model": f"model://{name}",
            "package": f"package://{self.folder.name}/{models}/{name}",
            "file": f"file://{models}/{name}",
        }[uri]
        scaled = "" if scale is None else f"<scale>{scale} {scale} {scale}</scale>"
        (at / "model.config").write_text(
            f'<?xml version="1.0"?>\n<model><name>{name}</name><version>1.0</version>'
            '<sdf version="1.6">model.sdf</sdf><author><name>a</name></author></model>\n'
        )
        shape = f"<geometry><mesh><uri>{begin}/{file}</uri>{scaled}</mesh></geometry>"
        (at / "model.sdf").write_text(
            f"""<?xml version="1.0" ?>
<sdf version="1.6"><model name="{name}"><link name="link"><inertial><mass>1</mass></inertial>
<collision name="collision"><laser_retro>0</laser_retro><!-- <bounce/> !-->{shape}
<surface><friction><ode><mu>0.3</mu></ode></friction></surface></collision>
<visual name="visual">{shape}<meta> <layer> 1 </layer></meta></visual></link>
<static>1</static></model></sdf>
"""
        )

    def put(self, name, pose="0 0 0 0 -0 0"):
        """Add an include of a model, in a model of its own with a place, as the worlds do."""
        number = sum(name in one for one in self.includes) + 1
        self.includes.append(
            f'<model name="{name}_{number:03}"><include><uri>model://{name}</uri></include>'
            f"<pose frame=''>{pose}</pose></model>"
        )

    def write(self, world):
        """Write the world file; return its path."""
        (self.folder / "worlds").mkdir(parents=True, exist_ok=True)
        (self.folder / "package.xml").write_text(
            f"<package><name>{self.folder.name}</name></package>"
        )
        path = self.folder / "worlds" / world
        path.write_text(
            "<?xml version='1.0' encoding='utf-8'?>\n<sdf version=\"1.6\"><world name=\"default\">"
            "<gui fullscreen='0'><camera name='c'><pose frame=''>-4 1 16 -0 0.9 -1.1</pose>"
            '</camera></gui><gravity>0 0 -9.8</gravity><physics default="0" name="p" type="ode"/>'
            + "\n".join(self.includes)
            + '<light name="l" type="point"><pose frame="">0 0 9 0 0 0</pose></light>'
            "<include><uri>model://sun</uri></include></world></sdf>\n"
        )
        return path


def walls(x, y, height, *, thick=0.15, door=None):
    """Four walls around a floor, with a partition along x whose door is open, if wanted."""
    found = [
        ((-x / 2, -y / 2, 0), (x, thick, height)),
        ((-x / 2, y / 2 - thick, 0), (x, thick, height)),
        ((-x / 2, -y / 2, 0), (thick, y, height)),
        ((x / 2 - thick, -y / 2, 0), (thick, y, height)),
    ]
    if door is not None:
        low, high = door
        found += [
            ((-x / 2, -thick / 2, 0), (low + x / 2, thick, height)),
            ((high, -thick / 2, 0), (x / 2 - high, thick, height)),
            ((low, -thick / 2, 2.1), (high - low, thick, height - 2.1)),
        ]
    return boxes(*found)


CHAIR = boxes(
    *(((x, y, 0), (0.04, 0.04, 0.44)) for x in (-0.22, 0.18) for y in (-0.22, 0.18)),
    ((-0.22, -0.22, 0.44), (0.44, 0.44, 0.04)),
    ((-0.22, 0.18, 0.48), (0.44, 0.04, 0.5)),
)
TABLE = boxes(
    *(((x, y, 0), (0.06, 0.06, 0.7)) for x in (-0.6, 0.54) for y in (-0.35, 0.29)),
    ((-0.6, -0.35, 0.7), (1.2, 0.7, 0.04)),
)
BED = boxes(((-1.0, -0.45, 0.3), (2.0, 0.9, 0.25)), ((-1.0, -0.45, 0.0), (0.05, 0.9, 1.0)))
RACK = boxes(*(((-1.2, -0.4, z), (2.4, 0.8, 0.06)) for z in (0.1, 1.1, 2.1)), *(
    ((x, y, 0), (0.08, 0.08, 2.6)) for x in (-1.2, 1.12) for y in (-0.4, 0.32)))  # fmt: skip


def hospital(folder, *, includes=100, floors=2):
    """A building of several floors: walls and slabs for each, and includes of furniture."""
    package = Package(folder=Path(folder))
    side, height = 20.0, 3.2
    slab = boxes(((-side / 2, -side / 2, -0.1), (side, side, 0.1)))
    package.model("hospital_floor_01_walls", walls(side, side, height, door=(1, 2)), unit_m=0.01)
    package.model("hospital_floor_01_floor", slab, up="Y_UP")
    package.model("hospital_floor_01_ceiling", (slab[0] + (0, 0, height + 0.1), slab[1]))
    how = {"models": "fuel_models", "uri": "model"}
    package.model("VisitorChair", CHAIR, kind="obj", **how)
    package.model("AdjTable", TABLE, kind="obj", scale=0.01, **how)
    package.model("TrolleyBed", BED, up="Y_UP", unit_m=0.01, **how)
    for floor in range(floors):
        for part in ("walls", "floor", "ceiling"):
            package.put(f"hospital_floor_01_{part}", f"0 0 {floor * (height + 0.2):.2f} 0 -0 0")
    rng = np.random.default_rng(5)
    for k in range(includes):
        x, y = rng.uniform(-9.0, 9.0, 2)
        z = (k % floors) * (height + 0.2)
        if abs(y) > 0.8:
            kind = ("VisitorChair", "AdjTable", "TrolleyBed")[k % 3]
            package.put(kind, f"{x:.6g} {y:.6g} {z:.6g} 0 -0 {rng.uniform(-3, 3):.6g}")
    # a chair that fell through the floor of a simulation that ran for long
    package.put("VisitorChair", "-8.9 9.2 -7.54989e+08 0 -0.152685 0")
    return package.write("hospital.world")


def warehouse(folder):
    """Shelves in a hall without a door, its floor a slab that begins below zero."""
    package = Package(folder=Path(folder))
    floor = boxes(((-7.0, -10.0, 0.0), (14.0, 20.0, 0.124)), ((1.3, -9.0, 0.124), (0.09, 18, 1e-4)))
    package.model("warehouse_GroundB_01", floor, uri="file", unit_m=0.01)
    package.model("warehouse_WallB_01", walls(14.0, 20.0, 8.0), uri="file", unit_m=0.01)
    package.model("warehouse_ShelfE_01", RACK, uri="file", unit_m=0.01)
    package.model("warehouse_Bucket_01", boxes(((-0.2, -0.2, 0), (0.4, 0.4, 0.4))), uri="package")
    lamp = boxes(((-0.5, -4.0, 11.0), (1.0, 0.1, 0.1)), ((-0.5, 4.0, 11.0), (1.0, 0.1, 0.1)))
    package.model("warehouse_Lamp_01", lamp, uri="file", unit_m=0.01)
    package.put("warehouse_GroundB_01", "0.0 0.0 -0.090092 0 0 0")
    package.put("warehouse_WallB_01")
    package.put("warehouse_Lamp_01", "0 0 -4 0 0 0")
    for y in (0.58, -4.83, -8.67):
        package.put("warehouse_ShelfE_01", f"4.73156 {y} 0 0 0 0")
    for x, y in ((0.43, 8.6), (-1.8, -6.4)):
        package.put("warehouse_Bucket_01", f"{x} {y} 0 0 0 -1.563161")
    return package.write("small_warehouse.world")


def small_house(folder):
    """Two rooms without a ceiling, carpets a millimetre thick, lamps in the air."""
    package = Package(folder=Path(folder))
    slab = boxes(((-4.0, -3.0, -0.02), (8.0, 6.0, 0.02)))
    package.model("residential_FloorB_01", slab, unit_m=0.01)
    house = walls(8.0, 6.0, 2.5, door=(-1.0, 0.2))
    package.model("residential_HouseWallB_01", house, unit_m=0.0254)
    package.model("residential_Carpet_01", boxes(((-1, -0.8, 0), (2, 1.6, 0.001))), up="Y_UP")
    package.model("residential_ChairA_01", CHAIR, unit_m=0.01)
    package.model("residential_KitchenTable_01", TABLE, unit_m=0.001)
    package.model("residential_Chandelier_01", boxes(((-0.2, -0.2, 0), (0.4, 0.4, 0.6))))
    package.put("residential_FloorB_01")
    package.put("residential_HouseWallB_01")
    package.put("residential_Carpet_01", "0.785050 -1.6 0.001106 0 -0 0")
    package.put("residential_KitchenTable_01", "-2.55 1.5 -0.000006 0 -0 -1.564130")
    for x, y in ((-2.5, 0.6), (-2.5, 2.4), (2.7, 1.5)):
        package.put("residential_ChairA_01", f"{x} {y} 0.011308 1e-06 -0 1.50414")
    package.put("residential_Chandelier_01", "1.22 1.6 1.795 0 -0 0")
    return package.write("small_house.world")


def turtlebot_house(folder):
    """A house of SDF boxes, several of a wall in one link, and a mailbox of DAE."""
    package = Package(folder=Path(folder))
    package.model("mailbox", boxes(((-0.1, -0.1, 0), (0.2, 0.2, 1.1))))
    size, wall = "9 0.15 2.5", []
    places = ("0 4.5 0 0 0 0", "0 -4.5 0 0 0 0", "4.5 0 0 0 0 1.5708", "-4.5 0 0 0 0 -1.5708")
    script = (
        "<material><script><uri>file://media/materials/scripts/gazebo.material</uri>"
        "<name>Gazebo/Bricks</name></script><ambient>1 1 1 1</ambient></material>"
    )
    for k, place in enumerate(places):
        shape = f"<pose frame=''>0 0 1.25 0 -0 0</pose><geometry><box><size>{size}</size></box>"
        wall.append(
            f"<link name='Wall_{k}'><pose frame=''>{place}</pose><self_collide>0</self_collide>"
            f"<visual name='v'>{shape}</geometry>{script}<transparency>0</transparency></visual>"
            f"<collision name='c'>{shape}</geometry></collision></link>"
        )
    at = package.folder / "models/turtlebot3_house"
    at.mkdir(parents=True)
    (at / "model.sdf").write_text(
        f"<sdf version='1.6'><model name='turtlebot3_house'>{''.join(wall)}<static>1</static>"
        "</model></sdf>"
    )
    package.includes.append("<include><uri>model://ground_plane</uri></include>")
    package.includes.append(
        "<include><pose>0 0 0 0 0 0</pose><uri>model://turtlebot3_house</uri></include>"
    )
    package.put("mailbox", "1.5 -1.5 0 0 0 0")
    return package.write("turtlebot3_house.world")


WORLDS = {
    "hospital": hospital,
    "warehouse": warehouse,
    "small_house": small_house,
    "turtlebot_house": turtlebot_house,
}
