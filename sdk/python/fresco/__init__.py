"""Runs fresco's pipelines from Python, and reads their results as NumPy arrays.

    import fresco

    room = fresco.run({"stages": {
        "scan":  {"type": "scan.recording", "path": "my_scan"},
        "mesh":  {"type": "mesh.decimate", "input": "scan", "max_faces": 200000},
        "atlas": {"type": "atlas.project", "input": "mesh", "size_px": 4096}}}, on_progress=print)
    mesh = room.read("atlas")             # mesh["positions"] is float32, V x 3
    print(room.figures("atlas")["charts"])

The work is done by the command `fresco`, which must be on the PATH, or `fresco.program` its path.
"""
from .pipeline import FrescoError, Progress, check, run
from .results import Result, open_results

program = "fresco"

__all__ = ["FrescoError", "Progress", "Result", "check", "open_results", "program", "run"]
