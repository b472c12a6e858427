"""blender --background --python import.py -- FOLDER: imports what run.sh exported; all must be the same room."""
import pathlib
import sys

import bpy
import numpy as np

if not hasattr(np, "bool"):
    np.bool = bool  # Debian 12's importer of glTF still asks for the name that its NumPy has dropped

folder = pathlib.Path(sys.argv[sys.argv.index("--") + 1])


def imported(name, operator, **options):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    operator(filepath=str(folder / name), **options)
    (room,) = [o for o in bpy.data.objects if o.type == "MESH"]
    mesh = room.data
    matrix = np.array(room.matrix_world)
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    points = points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
    uv = np.empty(2 * len(mesh.loops), np.float32)
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.uv_layers[0].data.foreach_get("uv", uv)
    mesh.loops.foreach_get("vertex_index", corners)
    print(f"read {name}: {len(mesh.polygons)} faces, {len(points)} vertices, pictures {[tuple(i.size) for i in bpy.data.images]}")
    # One row for each face: its middle and the middle of its texcoords.
    rows = np.hstack([points[corners].reshape(-1, 3, 3).mean(1), uv.reshape(-1, 3, 2).mean(1)])
    return rows, mesh


def z_up(rows):
    """glTF's importer turns +Y up into Blender's +Z: back to the world that fresco wrote."""
    rows = rows.copy()
    rows[:, [0, 1, 2]] = np.stack([rows[:, 0], rows[:, 2], -rows[:, 1]], 1)
    return rows


def same(name, rows, expected, off_m):
    assert rows.shape == expected.shape, f"{name}: {rows.shape[0]} faces, not {expected.shape[0]}"
    assert np.abs(rows[:, :3] - expected[:, :3]).max() <= off_m, f"{name}: positions differ by {np.abs(rows - expected)[:, :3].max()}"
    assert np.abs(rows[:, 3:] - expected[:, 3:]).max() <= 1e-5 + off_m / 10, f"{name}: texcoords differ by {np.abs(rows - expected)[:, 3:].max()}"


gltf = bpy.ops.import_scene.gltf
obj = bpy.ops.wm.obj_import
# Debian 12's Blender has only the older one.
ply = bpy.ops.wm.ply_import if "ply_import" in dir(bpy.ops.wm) else bpy.ops.import_mesh.ply
expected, mesh = imported("plain.glb", gltf)
expected = z_up(expected)
assert len(expected) > 1000 and np.ptp(expected[:, :3], axis=0).max() > 3
assert [tuple(i.size) for i in bpy.data.images if i.size[0]] == [(512, 512)]
rows, _ = imported("small.glb", gltf)
same("small.glb", z_up(rows), expected, 1e-5)
assert [tuple(i.size) for i in bpy.data.images if i.size[0]] == [(128, 128)]
# A model that was painted is the model that it was; its materials show the picture by the second set where there is one.
for name, sets, materials in (("keep.glb", 1, 1), ("second.glb", 2, 1), ("several.glb", 2, 2)):
    rows, mesh = imported(name, gltf)
    same(name, z_up(rows), expected, 1e-5)
    assert (len(mesh.uv_layers), len(mesh.materials)) == (sets, materials), name
    for material in mesh.materials:
        maps = [node.uv_map for node in material.node_tree.nodes if node.type == "UVMAP"]
        assert sets == 1 or maps == [mesh.uv_layers[1].name], f"{name}: {material.name} goes by {maps}"
# With up: z the world stands in Blender as it was written.
same("lit.glb", imported("lit.glb", gltf)[0], expected, 1e-5)
# A relief comes with its normals and roughness, and changes nothing else.
same("relief.glb", imported("relief.glb", gltf)[0], expected, 1e-5)
nodes = bpy.data.materials[0].node_tree.nodes
assert any(node.type == "NORMAL_MAP" for node in nodes) and len([node for node in nodes if node.type == "TEX_IMAGE"]) == 3
same("room.obj", imported("obj/room.obj", obj)[0], expected, 1e-5)
assert [tuple(i.size) for i in bpy.data.images if i.size[0]] == [(512, 512)]
same("vertex.ply", imported("vertex.ply", ply)[0], expected, 1e-5)
bpy.ops.wm.read_factory_settings(use_empty=True)
ply(filepath=str(folder / "colors.ply"))
(mesh,) = bpy.data.meshes
assert len(mesh.polygons) == len(expected) and len(mesh.color_attributes) == 1 and not mesh.uv_layers
# By default each format stands on its floor in Blender: within half a degree, as far as the scanned floor is level.
for name, operator in (("standing.glb", gltf), ("obj/standing.obj", obj), ("standing.ply", ply)):
    same(name, imported(name, operator)[0], expected, 0.04)
