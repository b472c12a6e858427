"""Blender add-on: paints the selected meshes in the style of a picture, by fresco's pipelines/model.yaml.

Install this file under Edit > Preferences > Add-ons. It needs the program fresco: on the PATH, or set in the add-on's preferences. Then the
sidebar of the 3D view (N) has a tab fresco. The painted mesh is added to the scene with its material; the selected ones are hidden.
"""
import pathlib
import shutil
import sys
import tempfile
import threading

import bpy
import numpy as np

bl_info = {
    "name": "fresco",
    "description": "Paints meshes in the style of a picture",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "View3D > Sidebar > fresco",
    "category": "Material",
}


class Stopped(Exception):
    pass


def fresco_package(program):
    """The Python package of the program, and its pipeline for models."""
    found = shutil.which(bpy.path.abspath(program))
    if not found:
        raise FileNotFoundError(f"the program '{program}' was not found: install fresco, or set its path in the preferences of this add-on")
    folder = pathlib.Path(found).resolve().parent.parent
    # Installed, or where it was built.
    for root in (folder / "share/fresco", folder.parent):
        if (root / "sdk/python/fresco").is_dir() and (root / "pipelines/model.yaml").is_file():
            if str(root / "sdk/python") not in sys.path:
                sys.path.insert(0, str(root / "sdk/python"))
            import fresco

            fresco.program = found
            return fresco, root / "pipelines/model.yaml"
    raise FileNotFoundError(f"{found} lacks its Python package and pipelines: install all of fresco")


class Painting:
    """One run of fresco in a thread of its own, which never touches Blender's data. Everything is in a temporary folder until take()."""

    def __init__(self, program, objects, picture, stroke_cm, painterly):
        if not objects:
            raise ValueError("no mesh is selected")
        if not picture:
            raise ValueError("choose a picture")
        fresco, pipeline = fresco_package(program)
        self.names = [thing.name for thing in objects]
        self.folder = tempfile.TemporaryDirectory(prefix="fresco-")
        root = pathlib.Path(self.folder.name)
        bpy.ops.object.select_all(action="DESELECT")
        for thing in objects:
            thing.select_set(True)
        bpy.ops.export_scene.gltf(filepath=str(root / "model.glb"), export_format="GLB", use_selection=True, export_apply=True)
        variables = {"model": str(root / "model.glb"), "picture": bpy.path.abspath(picture), "texture.painterly": painterly}
        if stroke_cm > 0:
            variables["texture.stroke_cm"] = stroke_cm
        self.progress, self.error, self.stopped = "", None, False

        def follow(progress):
            self.progress = str(progress)
            if self.stopped:
                raise Stopped

        def work():
            try:
                fresco.run(pipeline, variables, out=root / "out", store=root / "store", on_progress=follow)
            except Exception as error:
                self.error = error

        self.thread = threading.Thread(target=work)
        self.thread.start()

    def running(self):
        return self.thread.is_alive()

    def stop(self):
        """Waits until nothing is left."""
        self.stopped = True
        self.thread.join()
        self.folder.cleanup()

    def take(self):
        """The painted objects, in the scene and selected, of a painting that is not running. Raises what it failed by."""
        self.thread.join()
        try:
            if self.error:
                raise self.error
            bpy.ops.object.select_all(action="DESELECT")
            if "bool" not in vars(np):
                np.bool = bool  # Blender 3.4's importer names it, and Debian 12's NumPy has it no more.
            bpy.ops.import_scene.gltf(filepath=str(pathlib.Path(self.folder.name) / "out/room.glb"))
        finally:
            self.folder.cleanup()
        painted = [thing for thing in bpy.context.selected_objects if thing.type == "MESH"]
        for thing in painted:
            # The name is taken, so that Blender numbered the copy.
            thing.name = f"{thing.name.rpartition('.')[0] or thing.name} painted"
        for name in self.names:
            if name in bpy.context.view_layer.objects:
                bpy.context.view_layer.objects[name].hide_set(True)
        return painted


class FrescoSettings(bpy.types.PropertyGroup):
    picture: bpy.props.StringProperty(name="Picture", description="A painting or a photograph of one", subtype="FILE_PATH")
    stroke_cm: bpy.props.FloatProperty(name="Stroke (cm)", description="Width of a stroke in the world; 0: fresco's default", min=0, default=0)
    painterly: bpy.props.FloatProperty(name="Painterly", description="0 keeps what the surface shows, 1 is all strokes", min=0, max=1, default=0.35)


class FrescoPreferences(bpy.types.AddonPreferences):
    bl_idname = __name__
    program: bpy.props.StringProperty(name="Program", description="fresco, or its path", default="fresco", subtype="FILE_PATH")

    def draw(self, context):
        self.layout.prop(self, "program")


class OBJECT_OT_fresco_paint(bpy.types.Operator):
    """Paint the selected meshes in the style of the picture. Esc cancels"""

    bl_idname = "object.fresco_paint"
    bl_label = "Paint"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def begin(self, context):
        addon, settings = context.preferences.addons.get(__name__), context.scene.fresco
        objects = [thing for thing in context.selected_objects if thing.type == "MESH"]
        self.painting = Painting(addon.preferences.program if addon else "fresco", objects, settings.picture, settings.stroke_cm, settings.painterly)

    def failed(self, error):
        self.report({"ERROR"}, str(error))
        return {"CANCELLED"}

    def execute(self, context):
        try:
            self.begin(context)
            self.painting.take()
        except Exception as error:
            return self.failed(error)
        return {"FINISHED"}

    def invoke(self, context, event):
        try:
            self.begin(context)
        except Exception as error:
            return self.failed(error)
        self.timer = context.window_manager.event_timer_add(0.25, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type not in {"TIMER", "ESC"}:
            return {"PASS_THROUGH"}
        if event.type == "TIMER" and self.painting.running():
            context.workspace.status_text_set(f"fresco: {self.painting.progress} (Esc cancels)")
            return {"RUNNING_MODAL"}
        context.window_manager.event_timer_remove(self.timer)
        context.workspace.status_text_set(None)
        if event.type == "ESC":
            self.painting.stop()
            return {"CANCELLED"}
        try:
            self.painting.take()
        except Exception as error:
            return self.failed(error)
        return {"FINISHED"}


class VIEW3D_PT_fresco(bpy.types.Panel):
    bl_label = "fresco"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "fresco"

    def draw(self, context):
        for name in ("picture", "stroke_cm", "painterly"):
            self.layout.prop(context.scene.fresco, name)
        self.layout.operator(OBJECT_OT_fresco_paint.bl_idname, icon="BRUSH_DATA")


CLASSES = (FrescoSettings, FrescoPreferences, OBJECT_OT_fresco_paint, VIEW3D_PT_fresco)


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.fresco = bpy.props.PointerProperty(type=FrescoSettings)


def unregister():
    del bpy.types.Scene.fresco
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)


if __name__ == "__main__":
    register()
