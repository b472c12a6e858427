#!/usr/bin/env python3
"""Time to the same held-out distances: the released way of executing, and what each change to it brings.

Needs a built fresco, a scan in the layout of 7-Scenes and the weights of VGG-19 up to conv3_1. 20 frames are optimized for and 3 are
held out; heights 128, 216, 304 and 392, a texture of 1024², 2 steps in a row on a frame, θ_d 0.25 m. The distances are the method's
own: style on relu1_1, relu2_1 and relu3_1, content on relu3_1, without regularizer, the mean over the held-out frames, each on its own. A
mode is there when **both** are as low as the reference's at its end: their sum could be bought by one of them. Seconds count from the
start of the stage, without the measuring. Renders of the whole recording are compared by evaluate.reprojection, with one ray per pixel as
its floor has.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]

PIPELINE = """version: 1
base: {base}
vars: {{data: {data}, picture: {picture}, weights: {weights}}}
stages:
  scan: {{type: scan.recording, path: "${{data}}", every: 5}}
  frames: {{window_count: 1, max_frames: 23}}
  atlas: {{size_px: 1024}}
  uvmaps: {{heights_px: [128, 216, 304, 392]}}
  texture:
    theta_d_m: 0.25
    held_out_count: 3
    checkpoint_steps: 0
    losses:
      style: {{layers: "relu1_1, relu2_1, relu3_1", layer_weights: [1000, 1000, 10], features: {{convolutions: {convolutions}}}}}
      content: {{layers: relu3_1, weight: 900, features: {{convolutions: {convolutions}}}}}
{changes}
  whole: {{type: scan.recording, path: "${{data}}"}}
  views: {{input: {{mesh: bake, frames: whole}}, height_px: 480, samples: 1}}
  reprojection:
    type: evaluate.reprojection
    input: {{views: views, frames: whole, textured_mesh: bake}}
    gaps: [8, 24]
    every: 4
"""

EXACT = ["repeats_count: 2"]
# Each mode: the preset, who convolves, and what it changes.
MODES = {
    "reference": ("stylemesh-scannet", "libtorch", EXACT + ["optimizer: {untouched: step}"]),
    "+ minimal filtering": ("stylemesh-scannet", "auto", EXACT),
    "+ visible Adam": ("stylemesh-scannet", "auto", EXACT + ["optimizer: {mode: visible}"]),
    "+ frames as start": ("stylemesh-scannet", "auto", EXACT + ["optimizer: {mode: visible}", "init: frames"]),
    "fast": ("fast", "auto", []),
}


def quoted(path):
    return json.dumps(str(pathlib.Path(path).resolve()))


def run(options, mode):
    preset, convolutions, changes = MODES[mode]
    out = options.out / mode.replace("+ ", "").replace(" ", "_")
    out.mkdir(parents=True, exist_ok=True)
    (out / "pipeline.yaml").write_text(
        PIPELINE.format(base=quoted(ROOT / f"pipelines/presets/{preset}.yaml"), data=quoted(options.scan),
                        picture=quoted(options.picture), weights=quoted(options.weights), convolutions=convolutions,
                        changes="\n".join("    " + change for change in changes)))
    # The reference keeps the allocator's ways: what fresco sets for its stages is one of the changes.
    environment = dict(os.environ)
    if mode == "reference":
        environment["GLIBC_TUNABLES"] = ""
    command = [options.fresco, "run", out / "pipeline.yaml", "--out", out, "--store", options.out / "store", "--json-log",
               "--cores", str(options.cores)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    if done.returncode:
        sys.exit(f"{done.stdout[-2000:]}{done.stderr[-2000:]}\n{mode}: exit code {done.returncode}")
    summary = next(event for event in map(json.loads, reversed(done.stdout.splitlines())) if event["event"] == "summary")
    stage = next(stage for stage in summary["stages"] if stage["stage"] == "texture")
    manifest = json.loads(next((options.out / "store").rglob(f"{stage['object']}/manifest.json")).read_text())
    return {"report": manifest["report"], "memory_mb": manifest["memory_mb"],
            "reprojection": json.loads((out / "reprojection.json").read_text())}


DISTANCES = ("style_loss", "content_loss")


def reached(report, limits):
    """Step and seconds of the first measurement that is as low in every distance of `limits`."""
    for entry in report["held_out"]:
        if all(entry[key] <= limit for key, limit in limits.items()) and "seconds" in entry:
            return entry["step"], entry["seconds"]
    return None


def cell(there, base):
    return f"{there[0]:7}{there[1]:9.1f}{base[1] / there[1]:7.1f}" if there else f"{'-':>7}{'never':>9}{'-':>7}"


def say(results):
    reference = results["reference"]["report"]
    final = reference["held_out"][-1]
    limits = {key: 1.02 * final[key] for key in DISTANCES}
    print(f"\nheld-out distances of the reference after {final['step']} steps: style {final['style_loss']:.4g}, content "
          f"{final['content_loss']:.4g} (at the start {reference['held_out'][0]['style_loss']:.4g} and "
          f"{reference['held_out'][0]['content_loss']:.4g}); to reach: both within 2 %")
    if reached(reference, limits) is None:
        sys.exit("error: it is not known when the reference reached that, as its run was interrupted: delete the store and run again")
    columns = {"both": limits, "style": {"style_loss": limits["style_loss"]}, "content": {"content_loss": limits["content_loss"]}}
    bases = {name: reached(reference, wanted) for name, wanted in columns.items()}
    print(f"{'':39}" + "".join(f"{name:>23}" for name in columns))
    print(f"{'mode':22}{'s/step':>8}{'peak MB':>9}" + f"{'steps':>7}{'seconds':>9}{'times':>7}" * len(columns) + "   final style, content")
    for mode, result in results.items():
        report = result["report"]
        last = report["held_out"][-1]
        print(f"{mode:22}{report['seconds_per_step']:8.3f}{result['memory_mb']:9.0f}"
              + "".join(cell(reached(report, wanted), bases[name]) for name, wanted in columns.items())
              + f"   {last['style_loss']:.4g}, {last['content_loss']:.4g} after {last['step']} steps")
    print("\nreprojection, with the 95 % intervals that the stage gives")
    for mode, result in results.items():
        figures = [result["reprojection"][gap]["value"] for gap in ("short", "long")]
        print(f"{mode:22}" + "".join(f"{figure['value']:10.4g} [{figure['low']:.4g}, {figure['high']:.4g}]" for figure in figures))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scan", required=True, type=pathlib.Path, help="folder in the layout of 7-Scenes")
    parser.add_argument("--weights", required=True, type=pathlib.Path, help="VGG-19 up to conv3_1 or more")
    parser.add_argument("--picture", required=True, type=pathlib.Path)
    parser.add_argument("--modes", default=",".join(MODES), help="reference and some of: " + ", ".join(MODES))
    parser.add_argument("--cores", type=int, default=os.cpu_count())
    parser.add_argument("--fresco", default=ROOT / "build/bin/fresco", type=pathlib.Path)
    parser.add_argument("--out", default=ROOT / "build/held_out", type=pathlib.Path)
    options = parser.parse_args()
    modes = [mode.strip() for mode in options.modes.split(",")]
    for mode in modes:
        if mode not in MODES:
            parser.error(f"there is no mode {mode!r}; there are: {', '.join(MODES)}")
    results = {}
    for mode in dict.fromkeys(["reference"] + modes):
        results[mode] = run(options, mode)
        print(f"{mode}: {results[mode]['report']['seconds_per_step']:.3f} s/step", flush=True)
    say(results)
    return 0


if __name__ == "__main__":
    sys.exit(main())
