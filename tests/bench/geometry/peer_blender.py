"""blender --background --factory-startup --python peer_blender.py -- FOLDER decimate SHARE | unwrap SIZE_PX

Reads FOLDER/positions (float32 x 3) and FOLDER/triangles (uint32 x 3), runs the operator and writes what it made in the same form,
`texcoords` (float32 x 2 for each corner) too, and `seconds`, the time of the operator by itself.
"""
import math
import pathlib
import sys
import time

import bpy
import numpy as np

arguments = sys.argv[sys.argv.index("--") + 1:]
folder, task = pathlib.Path(arguments[0]), arguments[1]
positions = np.fromfile(folder / "positions", np.float32)
triangles = np.fromfile(folder / "triangles", np.uint32).astype(np.int32)

mesh = bpy.data.meshes.new("mesh")
mesh.vertices.add(len(positions) // 3)
mesh.vertices.foreach_set("co", positions)
mesh.loops.add(len(triangles))
mesh.loops.foreach_set("vertex_index", triangles)
faces = len(triangles) // 3
mesh.polygons.add(faces)
mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * faces, 3, dtype=np.int32))
mesh.polygons.foreach_set("loop_total", np.full(faces, 3, dtype=np.int32))
mesh.update(calc_edges=True)
thing = bpy.data.objects.new("thing", mesh)
bpy.context.collection.objects.link(thing)
bpy.context.view_layer.objects.active = thing
thing.select_set(True)

begin = time.monotonic()
if task == "decimate":
    modifier = thing.modifiers.new("decimate", "DECIMATE")
    modifier.ratio = float(arguments[2])
    bpy.ops.object.modifier_apply(modifier="decimate")
else:
    mesh.uv_layers.new()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    # As the paper's preparation: 70 degrees. The gutter is 4 texels.
    bpy.ops.uv.smart_project(angle_limit=math.radians(70), island_margin=4 / float(arguments[2]))
    bpy.ops.object.mode_set(mode="OBJECT")
seconds = time.monotonic() - begin

mesh = thing.data
mesh.calc_loop_triangles()
positions = np.empty(3 * len(mesh.vertices), np.float32)
mesh.vertices.foreach_get("co", positions)
triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
mesh.loop_triangles.foreach_get("vertices", triangles)
if mesh.uv_layers.active:
    loops = np.empty(len(triangles), np.int32)
    mesh.loop_triangles.foreach_get("loops", loops)
    texcoords = np.empty(2 * len(mesh.loops), np.float32)
    mesh.uv_layers.active.data.foreach_get("uv", texcoords)
    texcoords.reshape(-1, 2)[loops].tofile(folder / "texcoords")
positions.tofile(folder / "positions")
triangles.astype(np.uint32).tofile(folder / "triangles")
(folder / "seconds").write_text(f"{seconds:.3f}\n")
