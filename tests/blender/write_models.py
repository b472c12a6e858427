"""blender --background --factory-startup --python write_models.py -- FOLDER: a box with a red picture, in all formats that this Blender writes."""
import pathlib
import sys

import bpy

folder = pathlib.Path(sys.argv[sys.argv.index("--") + 1])
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_cube_add(size=2, location=(1, 2, 3))
box = bpy.context.object
box.scale = (1, 2, 3)
picture = bpy.data.images.new("red", 8, 8)
picture.pixels[:] = [1, 0, 0, 1] * 64
picture.filepath_raw, picture.file_format = str(folder / "red.png"), "PNG"
picture.save()
material = bpy.data.materials.new("red")
material.use_nodes = True
nodes = material.node_tree.nodes
texture = nodes.new("ShaderNodeTexImage")
texture.image = picture
material.node_tree.links.new(texture.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
box.data.materials.append(material)

bpy.ops.wm.save_as_mainfile(filepath=str(folder / "box.blend"))
for names, extension, options in (
    (("wm.fbx_export", "export_scene.fbx"), "fbx", {"path_mode": "COPY", "embed_textures": True}),
    (("wm.collada_export",), "dae", {}),
    (("wm.usd_export",), "usdz", {}),
    (("wm.stl_export", "export_mesh.stl"), "stl", {}),
):
    for group, name in (name.split(".") for name in names):
        if name in dir(getattr(bpy.ops, group)):
            getattr(getattr(bpy.ops, group), name)(filepath=str(folder / f"box.{extension}"), **options)
            break
