"""Reads and writes the mesh.ply that fresco exchanges meshes by, with NumPy: binary little-endian, only triangles."""
from __future__ import annotations

import pathlib
from typing import Any

import numpy as np

TYPES = {"float": "<f4", "uchar": "u1", "int": "<i4"}


def read_mesh(path: str | pathlib.Path) -> dict[str, Any]:
    """A dict of positions (V x 3 float32) and triangles (F x 3 int32), and where the file has them colors (V x 3 uint8), texcoords
    (F x 3 x 2 float32, origin at the lower left), charts (F int32), texture_px (the side of the texture that they are for) and
    offset_m (3 numbers to add to the positions, in double, for those of the world)."""
    file = pathlib.Path(path).read_bytes()
    header: list[str] = []
    end = 0
    while not header or header[-1] != "end_header":
        start, end = end, file.index(b"\n", end) + 1
        header.append(file[start:end].decode().strip())
    if header[:2] != ["ply", "format binary_little_endian 1.0"]:
        raise ValueError(f"{path}: no binary little-endian PLY")
    mesh: dict[str, Any] = {}
    counts: dict[str, int] = {}
    fields: dict[str, list[Any]] = {"vertex": [], "face": []}
    lists = {"vertex_indices": 3, "texcoord": 6}
    for words in (line.split() for line in header[2:-1]):
        if words[:2] == ["comment", "texture_px"]:
            mesh["texture_px"] = int(words[2])
        elif words[:2] == ["comment", "offset_m"]:
            mesh["offset_m"] = [float(word) for word in words[2:]]
        elif words[0] == "element":
            element = words[1]
            counts[element] = int(words[2])
        elif words[0] == "property" and words[1] == "list":
            name = words[4]
            fields[element] += [(name + "_count", TYPES[words[2]]), (name, TYPES[words[3]], lists[name])]
        elif words[0] == "property":
            fields[element].append((words[2], TYPES[words[1]]))
    vertices = np.frombuffer(file, np.dtype(fields["vertex"]), counts["vertex"], end)
    faces = np.frombuffer(file, np.dtype(fields["face"]), counts["face"], end + vertices.nbytes)
    if any((faces[f"{name}_count"] != length).any() for name, length in lists.items() if any(f[0] == name for f in fields["face"])):
        raise ValueError(f"{path}: has faces that are no triangles; fresco's own meshes have none")
    names = [name for name, *_ in fields["vertex"] + fields["face"]]
    mesh["positions"] = np.stack([vertices[axis] for axis in "xyz"], 1)
    mesh["triangles"] = faces["vertex_indices"]
    if "red" in names:
        mesh["colors"] = np.stack([vertices[channel] for channel in ("red", "green", "blue")], 1)
    if "texcoord" in names:
        mesh["texcoords"] = faces["texcoord"].reshape(-1, 3, 2)
    if "chart" in names:
        mesh["charts"] = faces["chart"]
    return mesh


def write_mesh(path: str | pathlib.Path, mesh: dict[str, Any]) -> None:
    """Writes what read_mesh gives."""
    vertex: list[Any] = [("x", "<f4"), ("y", "<f4"), ("z", "<f4")]
    face: list[Any] = [("corners", "u1"), ("vertex_indices", "<i4", 3)]
    lines = [f"comment texture_px {mesh['texture_px']}"] if "texture_px" in mesh else []
    lines += ["comment offset_m " + " ".join(str(number) for number in mesh["offset_m"])] if "offset_m" in mesh else []
    lines += [f"element vertex {len(mesh['positions'])}", *(f"property float {axis}" for axis in "xyz")]
    if "colors" in mesh:
        vertex += [(channel, "u1") for channel in ("red", "green", "blue")]
        lines += [f"property uchar {channel}" for channel in ("red", "green", "blue")]
    lines += [f"element face {len(mesh['triangles'])}", "property list uchar int vertex_indices"]
    if "texcoords" in mesh:
        face += [("numbers", "u1"), ("texcoord", "<f4", 6)]
        lines.append("property list uchar float texcoord")
    if "charts" in mesh:
        face.append(("chart", "<i4"))
        lines.append("property int chart")
    vertices = np.zeros(len(mesh["positions"]), np.dtype(vertex))
    for i, axis in enumerate("xyz"):
        vertices[axis] = mesh["positions"][:, i]
    for i, channel in enumerate(("red", "green", "blue")):
        if "colors" in mesh:
            vertices[channel] = mesh["colors"][:, i]
    faces = np.zeros(len(mesh["triangles"]), np.dtype(face))
    faces["corners"], faces["vertex_indices"] = 3, mesh["triangles"]
    if "texcoords" in mesh:
        faces["numbers"], faces["texcoord"] = 6, np.reshape(mesh["texcoords"], (-1, 6))
    if "charts" in mesh:
        faces["chart"] = mesh["charts"]
    header = "\n".join(["ply", "format binary_little_endian 1.0", *lines, "end_header", ""])
    pathlib.Path(path).write_bytes(header.encode() + vertices.tobytes() + faces.tobytes())
