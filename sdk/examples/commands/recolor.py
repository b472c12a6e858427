#!/usr/bin/env python3
"""recolor.py --in FOLDER --out FOLDER [--turn DEGREES]: turns the colors of a textured mesh's picture around the gray axis.

Needs only NumPy: a textured mesh is a folder with mesh.ply and image.npy, uint8 H x W x 3.
"""
import argparse
import pathlib
import shutil

import numpy as np

parser = argparse.ArgumentParser()
parser.add_argument("--in", dest="given", type=pathlib.Path, required=True)
parser.add_argument("--out", dest="made", type=pathlib.Path, required=True)
parser.add_argument("--turn", type=float, default=120)
arguments = parser.parse_args()

# Rodrigues' rotation around (1, 1, 1).
angle = np.radians(arguments.turn)
third, sine = (1 - np.cos(angle)) / 3, np.sin(angle) / np.sqrt(3)
turn = np.cos(angle) * np.eye(3) + third * np.ones((3, 3)) + sine * np.array([[0, -1, 1], [1, 0, -1], [-1, 1, 0]])

image = np.load(arguments.given / "image.npy")
rows = 256
for row in range(0, len(image), rows):
    block = image[row:row + rows].astype(np.float64) @ turn.T
    image[row:row + rows] = np.clip(np.rint(block), 0, 255)
    print(f"fresco: progress {min(row + rows, len(image))}/{len(image)} rows")

np.save(arguments.made / "image.npy", image)
shutil.copyfile(arguments.given / "mesh.ply", arguments.made / "mesh.ply")
print(f"turned {image.shape[1]}x{image.shape[0]} texels by {arguments.turn:g} degrees")
