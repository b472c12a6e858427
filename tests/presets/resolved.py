#!/usr/bin/env python3
"""resolved.py FRESCO PIPELINES [--write]: every option of every stage of the presets and of the paper's tables, against resolved/NAME.txt.

--write makes these files: look at their difference before committing it."""
import json
import pathlib
import struct
import subprocess
import sys
import tempfile

fresco, pipelines = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
golden = pathlib.Path(__file__).parent / "resolved"


def make_inputs(folder):
    """What `fresco check` looks for in a ScanNet scene, in a Matterport3D house and in weights."""
    for name in ("color", "depth", "pose", "undistorted_camera_parameters"):
        (folder / name).mkdir(parents=True)
    (folder / "undistorted_camera_parameters/house.conf").touch()
    header = json.dumps({"conv1_1.weight": {"dtype": "F16", "shape": [1], "data_offsets": [0, 2]}}).encode()
    (folder / "vgg19.safetensors").write_bytes(struct.pack("<Q", len(header)) + header + bytes(2))


def resolved(file, scans):
    """A line for each stage: its name, type and options."""
    scene, picture = scans / "scene0000_00", pipelines / "demo.jpg"
    data = f"scans={scans}" if file.parent.name.startswith("table") else f"data={scene}"
    settings = [data, f"picture=[{picture}]" if file.parent.name == "table1" else f"picture={picture}", f"weights={scene}/vgg19.safetensors"]
    done = subprocess.run([fresco, "check", file, "--json", *(word for text in settings for word in ("--set", text))], capture_output=True, text=True)
    report = json.loads(done.stdout)
    if not report["ok"]:
        sys.exit(f"{file}: {report['problems']}")
    text = "".join(f"{stage['name']}: {stage['type']} {json.dumps(stage['options'])}\n" for stage in report["stages"])
    return text.replace(str(scans), "SCANS").replace(str(pipelines), "PIPELINES")


wrong = False
with tempfile.TemporaryDirectory() as folder:
    scans = pathlib.Path(folder).resolve()
    make_inputs(scans / "scene0000_00")
    for file in sorted([*pipelines.glob("presets/*.yaml"), *pipelines.glob("paper/table*/*.yaml")]):
        if file.stem == "preview":
            continue
        kept = golden / (f"{file.parent.name}-{file.stem}" if file.parent.name.startswith("table") else file.stem)
        kept = kept.with_suffix(".txt")
        found = resolved(file, scans).splitlines()
        if "--write" in sys.argv:
            kept.write_text("\n".join(found) + "\n")
        before = kept.read_text().splitlines() if kept.exists() else []
        if found != before:
            wrong = True
            print(f"{file}: not the options of {kept.name}; if they are meant to change: {pathlib.Path(__file__).name} FRESCO PIPELINES --write")
            print("\n".join([f"- {line}" for line in before if line not in found] + [f"+ {line}" for line in found if line not in before]))
sys.exit(wrong)
