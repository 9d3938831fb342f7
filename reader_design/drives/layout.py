"""A layout of Foxglove's panels for the topics of a drive: scene, RSS, bearing, speeds, state."""

import json
from typing import Any

LAYOUT_NAME = "foxglove_layout.json"
_COLOURS = (
    "#332288", "#cc6677", "#117733", "#ddaa33", "#88ccee", "#aa4499", "#44aa99", "#882255",
)  # fmt: skip
_SHOWN = (
    "/room", "/tags", "/robot", "/map", "/plan", "/ground_truth/path", "/ground_truth/pose",
    "/belief/pose", "/belief/tag", "/bearing",
)  # fmt: skip


def layout_text(antennas: int) -> str:
    """Return the layout as the JSON text that Foxglove imports ("Import from file").

    Parameters
    ----------
    antennas : Of the reader; 0: no panels of readings.
    """
    config: dict[str, Any] = {
        "3D!octant": {
            "followTf": "map",
            "followMode": "follow-none",
            "topics": {name: {"visible": name != "/ground_truth/pose"} for name in _SHOWN},
            "scene": {},
            "cameraState": {
                "perspective": True,
                "distance": 12.0,
                "phi": 45.0,
                "thetaOffset": 0.0,
                "targetOffset": [0.0, 0.0, 0.0],
                "target": [0.0, 0.0, 0.0],
                "targetOrientation": [0.0, 0.0, 0.0, 1.0],
                "fovy": 45.0,
                "near": 0.05,
                "far": 500.0,
            },
        },
        "Plot!speeds": _plot(
            "Commands [m/s], [rad/s]",
            [("/cmd_vel.linear.x", "speed"), ("/cmd_vel.angular.z", "turn rate")],
        ),
        "RawMessages!state": {"topicPath": "/state", "diffEnabled": False},
    }
    right: Any = {
        "direction": "column",
        "first": "Plot!speeds",
        "second": "RawMessages!state",
        "splitPercentage": 70,
    }
    if antennas:
        config["Plot!rss"] = _plot(
            "RSS [dBm]", [(f"/rss_dbm.data[{i}]", f"antenna {i + 1}") for i in range(antennas)]
        )
        config["Plot!bearing"] = _plot(
            "Bearing of the tag [deg]",
            [("/bearing_deg.data", "read"), ("/ground_truth/bearing_deg.data", "true")],
        )
        readings = {
            "direction": "column",
            "first": "Plot!rss",
            "second": "Plot!bearing",
            "splitPercentage": 55,
        }
        right = {
            "direction": "column",
            "first": readings,
            "second": right,
            "splitPercentage": 62,
        }
    layout = {
        "configById": config,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": {
            "direction": "row",
            "first": "3D!octant",
            "second": right,
            "splitPercentage": 60,
        },
    }
    return json.dumps(layout, indent=1) + "\n"


def _plot(title: str, lines: list[tuple[str, str]]) -> dict[str, Any]:
    return {
        "foxglovePanelTitle": title,
        "paths": [
            {
                "value": value,
                "label": label,
                "enabled": True,
                "timestampMethod": "receiveTime",
                "color": _COLOURS[i % len(_COLOURS)],
            }
            for i, (value, label) in enumerate(lines)
        ],
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "showLegend": True,
        "legendDisplay": "floating",
        "isSynced": True,
        "xAxisVal": "timestamp",
    }
