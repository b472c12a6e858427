"""Paints a generated room from Python, looks at how it was recorded and painted, and tries two stroke widths.

Cells begin with "# %%", as notebooks and editors know them. paint_room.py --preview runs it all with fewer frames, faces and texels.
"""
# %% The pipeline, as in a file: a recording, a picture, and what becomes of them.
import pathlib
import sys

import numpy as np

import fresco

picture = str(pathlib.Path(__file__).resolve().parents[3] / "pipelines/pictures/night_sky.jpg")
room = {
    "vars": {"stroke_cm": 4},
    "stages": {
        "scan": {"type": "scan.synthetic_room"},
        "mesh": {"type": "mesh.decimate", "input": "scan", "max_faces": 120000},
        "atlas": {"type": "atlas.project", "input": "mesh", "size_px": 2048},
        "uvmaps": {"type": "uvmaps.raster", "input": {"mesh": "atlas", "frames": "scan"}, "heights_px": [240]},
        "photo": {"type": "texture.from_frames", "input": {"uvmaps": "uvmaps", "frames": "scan"}},
        "texture": {"type": "texture.synthesize", "input": {"mesh": "atlas", "start": "photo", "frames": "scan", "style": {"file": picture}},
                    "stroke_cm": "${stroke_cm}"},
        "bake": {"type": "texture.bake", "input": {"texture": "texture", "mesh": "atlas"}},
        "glb": {"type": "export.gltf", "input": {"textured_mesh": "bake", "frames": "scan"}, "path": "room.glb"},
    },
    "preview": {"scan": {"frames_count": 12}, "mesh": {"max_faces": 40000}, "atlas": {"size_px": 512}},
}
preview = "--preview" in sys.argv

# %% Run it; what is cached is not run again.
result = fresco.run(room, preview=preview, on_progress=lambda progress: print(progress, end="   \r", flush=True))
print(f"\n{result.files[0]} after {result.data['seconds']:.0f} s")

# %% How much of the recorded pictures shows the surface, and how far away it is.
for (view, height), uv_map in list(result.read("uvmaps").items())[:3]:
    print(f"view {view}: {uv_map['valid'].mean():.0%} surface, {uv_map['depth'][uv_map['valid']].mean():.2f} m away on average")

# %% Where the painting differs from the photograph.
photo, painting = result.read("photo")[0], result.read("texture", "texture")[0]
print(f"mean difference of colors: {np.abs(photo - painting).mean():.3f}")

# %% The same room with broader strokes: only what depends on them runs.
broad = fresco.run(room, {"stroke_cm": 8}, preview=preview)
print("ran again:", ", ".join(name for name, stage in broad.stages.items() if stage["state"] == "ran"))
