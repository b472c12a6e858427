"""blender --background --python import_model.py -- MODEL GLB: reads a model by the importer that this Blender has for it, and writes it as GLB with z up."""
import os
import sys

import addon_utils
import bpy

# The newer of two importers comes first.
IMPORTERS = {
    ".3ds": ["import_scene.max3ds"],
    ".abc": ["wm.alembic_import"],
    ".blend": ["wm.open_mainfile"],
    ".dae": ["wm.collada_import"],
    ".fbx": ["wm.fbx_import", "import_scene.fbx"],
    ".stl": ["wm.stl_import", "import_mesh.stl"],
    ".wrl": ["import_scene.x3d"],
    ".x3d": ["import_scene.x3d"],
    **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz"), ["wm.usd_import"]),
}


def operator(name):
    """None where this Blender was built without it."""
    group, name = name.split(".")
    return getattr(getattr(bpy.ops, group), name) if name in dir(getattr(bpy.ops, group)) else None


def call(run, **options):
    """Options that this version does not know are left out."""
    known = run.get_rna_type().properties.keys()
    if run(**{key: value for key, value in options.items() if key in known}) != {"FINISHED"}:
        raise RuntimeError("Blender gave up")


def say(*words):
    print("fresco:", *words, flush=True)


model, glb = sys.argv[sys.argv.index("--") + 1:]
say("version", bpy.app.version_string)
bpy.ops.wm.read_factory_settings(use_empty=True)
for addon in ("io_scene_3ds", "io_scene_x3d", "io_scene_gltf2"):
    if addon in (module.__name__ for module in addon_utils.modules()):
        addon_utils.enable(addon)
importers = [found for name in IMPORTERS.get(os.path.splitext(model)[1].lower(), []) if (found := operator(name))]
if importers:
    call(importers[0], filepath=model, load_ui=False, use_scripts=False)
    # Some importers print what went wrong and go on.
    if not bpy.data.objects:
        raise RuntimeError("Blender found nothing in it")
    for path in bpy.utils.blend_paths(absolute=True):
        say("file", path)
    call(bpy.ops.export_scene.gltf, filepath=glb, export_format="GLB", export_yup=False, export_apply=True, export_skins=False,
         export_morph=False, export_animations=False, export_vertex_color="ACTIVE")
else:
    say("no importer")
