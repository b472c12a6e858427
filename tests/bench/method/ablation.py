#!/usr/bin/env python3
"""The paper's ablation at a fraction of its steps: only 2D, angle, angle and depth, on one scan.

Needs a built fresco. Every run is a pipeline over the preset of its mode, with that preset's own start (zeros), λ_r, dense Adam and
step decay; the steps are fewer because fewer frames are used and each is repeated less often. What runs share is stored once. Circle
pictures are painted with only the style loss, as in the paper's Table 2; other pictures with content, as in Table 1.
Views are drawn with one ray per pixel, as the floor of the reprojection is: a smoother picture would fall below its floor.
Prints where the losses on held-out frames stand on the way, then a table with 95 % bootstrap intervals over pictures, and says where
an order holds: only where intervals do not overlap. Writes OUT/pictures.html: the same views in all modes, side by side.
"""

import argparse
import concurrent.futures
import html
import json
import os
import pathlib
import subprocess
import sys
import time

from evaluation_table import over_seeds, table

ROOT = pathlib.Path(__file__).resolve().parents[3]
MODES = {"only 2D": "only-2d-scannet", "angle": "angle-scannet", "angle and depth": "stylemesh-scannet"}
PAPER_STEPS = 125 * 10 * 7  # Of a recording as long as the kitchen.
EPOCHS = 7

PIPELINE = """version: 1
base: {base}
vars: {{data: {data}, picture: {picture}, weights: {weights}}}
stages:
{scan}
  mesh: {{{mesh_input}max_faces: {faces}}}
  atlas: {{size_px: {size}}}
  texture:
    theta_d_m: {theta_d}
    repeats_count: {repeats}
    seed: {seed}
    held_out_count: 2
    measure_steps: {measure}
    losses: {{{losses}}}
  views: {{type: render.views, input: {{mesh: bake, frames: scan}}, height_px: {height}, samples: 1}}
  glb:
  reprojection:
    type: evaluate.reprojection
    input: {{views: views, frames: scan, textured_mesh: bake}}
    short_gap: {short}
    long_gap: {long}
    every: 4
"""

# VGG-19 that ends at conv3_1: content moves to relu3_1, fainter than relu4_2, with a weight that puts style over content at the first
# step back to about 1.5, as with all layers.
CUT_STYLE = 'layers: "relu1_1, relu2_1, relu3_1", layer_weights: [1000, 1000, 10]'
CUT_CONTENT = "layers: relu3_1, weight: 900"

RECORDED = """  scan: {{type: scan.seven_scenes, path: "${{data}}"}}
  frames: {{type: frames.sharpest, input: scan, window_count: 1, max_frames: {frames}}}"""

# Looked along, the room is 6 m deep and more.
GENERATED = """  scan: {{type: scan.synthetic_room, length_m: 7.5, width_m: 4, frames_count: 60, keep_unseen: true}}
  frames: {{type: frames.sharpest, input: scan, window_count: 1, max_frames: {frames}}}"""

# Circles of a radius below 10 px do not count: drawn too small, only the largest of the distant ones would.
CIRCLES = """  large_views:
    {{type: render.views, input: {{mesh: bake, frames: scan}}, folder: large_views, height_px: {height}, samples: 1, every_count: {every}}}
  circles: {{type: evaluate.circles, input: {{views: large_views, frames: scan, textured_mesh: bake}}}}
"""


def quoted(path):
    return json.dumps(str(pathlib.Path(path).resolve()))


def has_circles(picture):
    return "circle" in picture.stem


def losses(options, picture):
    style = f"style: {{{CUT_STYLE}}}" if options.cut else ""
    if has_circles(picture):
        return f"{style}, content: " if style else "content: "
    return f"{style}, content: {{{CUT_CONTENT}}}" if options.cut else ""


def pipeline(options, mode, picture, seed):
    text = PIPELINE.format(
        base=quoted(ROOT / "pipelines/presets" / (MODES[mode] + ".yaml")),
        data=quoted(options.scan or "."),
        picture=quoted(picture),
        weights=quoted(options.weights),
        scan=(RECORDED if options.scan else GENERATED).format(frames=options.frames + 2),
        mesh_input="" if options.scan else "input: scan, ",
        faces=options.faces,
        size=options.size,
        theta_d=options.theta_d,
        repeats=options.repeats,
        seed=seed,
        measure=max(1, options.steps // 8),
        losses=losses(options, picture),
        height=options.height,
        short=options.short_gap,
        long=options.long_gap,
    )
    if has_circles(picture):
        text += CIRCLES.format(height=options.circle_height, every=options.circles_every)
    return text


def optimizer_report(options, log):
    """What the texture's stage reported, from the store."""
    summary = next(event for event in map(json.loads, reversed(log.splitlines())) if event["event"] == "summary")
    stage = next(stage for stage in summary["stages"] if stage["stage"] == "texture")
    return json.loads(next((options.out / "store").rglob(f"{stage['object']}/manifest.json")).read_text())["report"]


def say_curves(report):
    """Held-out losses on the way, so that a reader sees how far from its end the run is."""
    if "initial_style_over_content" in report:
        print(f"  style over content at the first step: {report['initial_style_over_content']:.3g}")
    for key in ("loss", "style_loss", "content_loss"):
        values = [entry.get(key) for entry in report["held_out"]]
        if None not in values:
            print(f"  held-out {key:13}" + " ".join(f"{value:.3g}" for value in values))


def run(options, mode, picture, seed):
    out = options.out / f"{mode.replace(' ', '_')}-{picture.stem}-{seed}"
    out.mkdir(parents=True, exist_ok=True)
    (out / "pipeline.yaml").write_text(pipeline(options, mode, picture, seed))
    begin = time.time()
    cores = max(1, options.cores // options.jobs)
    command = [options.fresco, "run", out / "pipeline.yaml", "--out", out, "--store", options.out / "store", "--json-log",
               "--cores", str(cores)]
    with open(out / "log.txt", "w") as log:
        code = subprocess.run(command, stdout=log, stderr=log).returncode
    if code:
        raise RuntimeError((out / "log.txt").read_text()[-3000:] + f"\n{mode}, {picture.name}, seed {seed}: exit code {code}")
    report = optimizer_report(options, (out / "log.txt").read_text())
    print(f"{mode}, {picture.name}, seed {seed}: {time.time() - begin:.0f} s, {report['seconds_per_step']:.2f} s/step", flush=True)
    say_curves(report)
    figures = {"reprojection": json.loads((out / "reprojection.json").read_text())}
    if has_circles(picture):
        figures["circles"] = json.loads((out / "circles.json").read_text())
    return figures


def pictures_page(options, modes):
    """One row for each picture and view, one column for each mode."""
    lines = ["<!doctype html><meta charset=utf-8><title>Ablation</title><style>body{font:14px sans-serif}img{width:32vw}</style>"]
    for picture in options.picture:
        folders = [options.out / f"{mode.replace(' ', '_')}-{picture.stem}-0" for mode in modes]
        lines.append(f"<h2>{html.escape(picture.name)}: {html.escape(' | '.join(modes))}</h2>")
        views = sorted((folders[0] / "views").glob("*.png"))
        for view in views[:: max(1, len(views) // 6)]:
            lines.append("<div>")
            for folder in folders:
                lines.append(f"<img loading=lazy src='{html.escape(os.path.relpath(folder / 'views' / view.name, options.out))}'>")
            lines.append("</div>")
    (options.out / "pictures.html").write_text("\n".join(lines) + "\n")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scan", type=pathlib.Path, help="folder in the layout of 7-Scenes; none: a generated room of 7.5 m")
    parser.add_argument("--weights", required=True, type=pathlib.Path, help="VGG-19")
    parser.add_argument("--picture", required=True, type=pathlib.Path, action="append", help="a name with 'circle' is measured as such")
    parser.add_argument("--seeds", type=int, default=1, help="orders of the frames for circle pictures")
    parser.add_argument("--cut", action="store_true", help="the weights end at conv3_1: style up to relu3_1, content on relu3_1")
    parser.add_argument("--modes", default=",".join(MODES), help="some of: " + ", ".join(MODES))
    parser.add_argument("--frames", type=int, default=25, help="to train with; two more are held out")
    parser.add_argument("--repeats", type=int, default=3, help="consecutive steps on a frame; the paper: 10")
    parser.add_argument("--size", type=int, default=2048, help="texels a side")
    parser.add_argument("--faces", type=int, default=500000)
    parser.add_argument("--theta-d", type=float, help="meters; default 0.12 for a scan, 0.25 for the generated room")
    parser.add_argument("--height", type=int, default=784, help="of the rendered views")
    parser.add_argument("--circle-height", type=int, default=1960, help="of the views that circles are looked for in")
    parser.add_argument("--circles-every", type=int, help="look in every n-th view; default 5 for a scan, 3 for the generated room")
    parser.add_argument("--short-gap", type=int, help="recorded frame numbers; default 8 for a scan, 1 for the generated room")
    parser.add_argument("--long-gap", type=int, help="default 24 for a scan, 4 for the generated room")
    parser.add_argument("--fresco", default=ROOT / "build/bin/fresco", type=pathlib.Path)
    parser.add_argument("--out", default=ROOT / "build/ablation", type=pathlib.Path)
    parser.add_argument("--cores", type=int, default=os.cpu_count())
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time; they share the cores")
    options = parser.parse_args()
    options.theta_d = options.theta_d or (0.12 if options.scan else 0.25)
    options.short_gap = options.short_gap or (8 if options.scan else 1)
    options.long_gap = options.long_gap or (24 if options.scan else 4)
    options.circles_every = options.circles_every or (5 if options.scan else 3)
    options.modes = [mode.strip() for mode in options.modes.split(",")]
    options.steps = EPOCHS * options.frames * options.repeats
    for mode in options.modes:
        if mode not in MODES:
            parser.error(f"there is no mode {mode!r}; there are: {', '.join(MODES)}")
    return options


def main():
    options = arguments()
    print(f"{options.steps} steps ({options.frames} frames x {options.repeats} x {EPOCHS} epochs), "
          f"{100 * options.steps / PAPER_STEPS:.1f} % of the paper's {PAPER_STEPS} for 125 frames; {options.size}², "
          f"θ_d {options.theta_d} m", flush=True)
    cases = [(mode, picture, seed) for picture in options.picture
             for seed in range(options.seeds if has_circles(picture) else 1) for mode in options.modes]
    # The first run by itself makes what all share.
    results = {cases[0]: run(options, *cases[0])}
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        waiting = {case: pool.submit(run, options, *case) for case in cases[1:]}
        for case, future in waiting.items():
            results[case] = future.result()
    for picture in options.picture:
        runs = {mode: [figures for (m, p, _), figures in results.items() if m == mode and p == picture] for mode in options.modes}
        title = f"{picture.name}, {len(runs[options.modes[0]])} orders: " + " | ".join(options.modes)
        table(title, {mode: over_seeds(several) for mode, several in runs.items()}, runs)
    pictures_page(options, options.modes)
    print(f"\nside by side: {options.out / 'pictures.html'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
