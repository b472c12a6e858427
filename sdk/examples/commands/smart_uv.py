"""blender --background --factory-startup --python smart_uv.py -- IN.ply OUT.ply SIZE_PX ANGLE_DEG: texcoords by smart uv project.

Blender brings its own Python with NumPy. SIZE_PX is the texture's side: the gutter is 4 of its texels, and what paints takes it.
"""
import math
import pathlib
import sys

import bpy
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import fresco_ply

given, made, size_px, angle_deg = sys.argv[sys.argv.index("--") + 1:]
mesh = fresco_ply.read_mesh(given)
faces = len(mesh["triangles"])

body = bpy.data.meshes.new("mesh")
body.vertices.add(len(mesh["positions"]))
body.vertices.foreach_set("co", mesh["positions"].ravel())
body.loops.add(3 * faces)
body.loops.foreach_set("vertex_index", mesh["triangles"].ravel())
body.polygons.add(faces)
body.polygons.foreach_set("loop_start", np.arange(0, 3 * faces, 3, dtype=np.int32))
body.polygons.foreach_set("loop_total", np.full(faces, 3, dtype=np.int32))
body.update(calc_edges=True)
body.uv_layers.new()
thing = bpy.data.objects.new("thing", body)
bpy.context.collection.objects.link(thing)
bpy.context.view_layer.objects.active = thing
thing.select_set(True)

print(f"fresco: message smart uv project of {faces} faces")
bpy.ops.object.mode_set(mode="EDIT")
bpy.ops.mesh.select_all(action="SELECT")
bpy.ops.uv.smart_project(angle_limit=math.radians(float(angle_deg)), island_margin=4 / float(size_px))
bpy.ops.object.mode_set(mode="OBJECT")

texcoords = np.empty(6 * faces, np.float32)
body.uv_layers.active.data.foreach_get("uv", texcoords)
mesh["texcoords"] = np.clip(texcoords, 0, 1).reshape(faces, 3, 2)
mesh.pop("charts", None)
mesh["texture_px"] = int(size_px)
fresco_ply.write_mesh(made, mesh)
