"""The ROS 2 package ``octant_drive``."""

from setuptools import setup

NAME = "octant_drive"

setup(
    name=NAME,
    version="0.1.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", ["launch/drive.launch.py"]),
    ],
    install_requires=["setuptools", "octant"],
    license="Apache-2.0",
    description="Drives a robot to RFID tags by Octant's navigators; simulates their reader.",
    entry_points={
        "console_scripts": [
            f"rss_node = {NAME}.rss_node:main",
            f"drive_node = {NAME}.drive_node:main",
        ]
    },
)
