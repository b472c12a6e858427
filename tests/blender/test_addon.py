"""blender --background --factory-startup --python test_addon.py -- ADDON PICTURE: the add-on, as a user installs it."""
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import bpy
import numpy as np

addon, picture = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.preferences.addon_install(filepath=addon)
bpy.ops.preferences.addon_enable(module="fresco_addon")
module = sys.modules["fresco_addon"]
temporary = pathlib.Path(tempfile.gettempdir())


def corners(objects):
    depsgraph = bpy.context.evaluated_depsgraph_get()
    points = np.array([thing.matrix_world @ vertex.co for thing in objects for vertex in thing.evaluated_get(depsgraph).data.vertices])
    return np.array([points.min(0), points.max(0)])


def left_over():
    running = subprocess.run(["ps", "ax", "-o", "args"], capture_output=True, text=True, check=True).stdout
    return sorted(temporary.glob("fresco-*")), [line for line in running.splitlines() if "--json-log" in line and str(temporary) in line]


bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()
bpy.ops.mesh.primitive_monkey_add(size=2, location=(1, 2, 0.5), rotation=(0.3, 0.2, 0.1))
monkey = bpy.context.object
monkey.modifiers.new("smooth", "SUBSURF").levels = int(os.environ.get("FRESCO_TEST_LEVELS", "2"))
settings = bpy.context.scene.fresco

# What is missing is said.
for picture_given, word in (("", "choose a picture"), ("/nothing.jpg", "/nothing.jpg")):
    settings.picture = picture_given
    try:
        bpy.ops.object.fresco_paint()
        sys.exit(f"'{picture_given}' was painted with")
    except RuntimeError as error:
        assert word in str(error), error
assert left_over() == ([], []), left_over()

# Stopped in the middle: nothing is left of it.
painting = module.Painting("fresco", [monkey], picture, 0, 0.5)
while "running: " not in painting.progress and painting.running():
    time.sleep(0.05)
painting.stop()
assert isinstance(painting.error, module.Stopped), painting.error
assert left_over() == ([], []), left_over()
assert [thing.name for thing in bpy.data.objects] == [monkey.name]

# A second object, with two materials and no texture coordinates.
bpy.ops.mesh.primitive_cube_add(location=(4, 2, 0.5))
cube = bpy.context.object
cube.data.uv_layers.remove(cube.data.uv_layers[0])
for number, color in enumerate(((1, 0, 0, 1), (0, 1, 0, 1))):
    material = bpy.data.materials.new(f"side {number}")
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = color
    cube.data.materials.append(material)
cube.data.polygons[0].material_index = 1
monkey.select_set(True)

# Painted: in the same place, with materials that have the picture's colors, the originals hidden.
settings.picture, settings.stroke_cm, settings.painterly = picture, 6, 0.8
begin = time.monotonic()
assert bpy.ops.object.fresco_paint() == {"FINISHED"}
print(f"painted {len(monkey.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.polygons)} faces in {time.monotonic() - begin:.0f} s")
painted = sorted(bpy.context.selected_objects, key=lambda thing: thing.name)
assert [thing.name for thing in painted] == ["Cube painted", "Suzanne painted"], painted
assert monkey.hide_get() and cube.hide_get() and left_over() == ([], [])
for before, after in zip((cube, monkey), painted):
    assert np.abs(corners([after]) - corners([before])).max() < 1e-4, (corners([after]), corners([before]))
    shape = before.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    shape.calc_loop_triangles()
    assert len(after.data.polygons) == len(shape.loop_triangles)
    assert len(after.data.uv_layers) in (len(shape.uv_layers), len(shape.uv_layers) + 1)
    assert len(after.data.materials) == max(1, len(shape.materials))
    for material in after.data.materials:
        images = [node.image for node in material.node_tree.nodes if node.type == "TEX_IMAGE"]
        assert len(images) == 1 and images[0].packed_file
        texels = np.array(images[0].pixels[:]).reshape(images[0].size[1], images[0].size[0], 4)[..., :3]
        assert texels.std() > 0.05 and np.ptp(texels, axis=-1).mean() > 0.1, (texels.std(), np.ptp(texels, axis=-1).mean())

# Installed in Blender, it goes again.
bpy.ops.preferences.addon_disable(module="fresco_addon")
assert not hasattr(bpy.types.Scene, "fresco")
