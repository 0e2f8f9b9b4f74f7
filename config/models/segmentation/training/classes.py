"""CARLA's 23 classes, and what the labels of each data set mean in them."""

from __future__ import annotations

import numpy as np

NAMES = (
    "Unlabeled", "Building", "Fence", "Other", "Pedestrian", "Pole", "RoadLine", "Road", "SideWalk", "Vegetation",
    "Vehicles", "Wall", "TrafficSign", "Sky", "Ground", "Bridge", "RailTrack", "GuardRail", "TrafficLight", "Static",
    "Dynamic", "Water", "Terrain",
)
CLASS_COUNT = len(NAMES)
UNLABELED = 0
IGNORE = 255
ID = {name: index for index, name in enumerate(NAMES)}

# What a coarser data set calls by one name: label -> classes of ours that it may be. The label stands for itself too.
Merges = dict[str, tuple[str, ...]]

TOWN: Merges = {}
# CARLA 0.8 has 13 labels: lights are signs, grass is vegetation, and street furniture is Other.
CARLA: Merges = {
    "TrafficSign": ("TrafficLight",),
    "Vegetation": ("Terrain",),
    "Other": ("Static", "Dynamic"),
}
CAMVID11: Merges = {
    "Road": ("RoadLine",),
    "Building": ("Wall", "Bridge"),
    "TrafficSign": ("TrafficLight",),
    "Vegetation": ("Terrain",),
}
CAMVID32: Merges = {"Vegetation": ("Terrain",), "Building": ("Bridge",)}

MAX_MEMBERS = 1 + max(len(members) for merges in (TOWN, CARLA, CAMVID11, CAMVID32) for members in merges.values())


def member_table(merges: Merges) -> np.ndarray:
    """Classes that a label stands for: CLASS_COUNT x MAX_MEMBERS, padded with -1."""
    table = np.full((CLASS_COUNT, MAX_MEMBERS), -1, np.int64)
    for label, name in enumerate(NAMES):
        members = (name,) + merges.get(name, ())
        table[label, : len(members)] = [ID[member] for member in members]
    return table


def merge_table(merges: Merges) -> np.ndarray:
    """The label that a predicted class counts as in a data set with these merges: CLASS_COUNT values."""
    table = np.arange(CLASS_COUNT, dtype=np.uint8)
    for label, members in merges.items():
        for member in members:
            table[ID[member]] = ID[label]
    return table
