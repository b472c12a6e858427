#!/usr/bin/env python3
"""The paper's ablation, shortened: only 2D, angle, angle and depth, on one scan with one schedule.

Needs a built fresco. Every run is a pipeline over the preset of its mode, by the style loss alone; what runs share is stored once.
All modes start from noise: on a flat start the style loss alone pulls every pixel of a plain wall alike. There is no regulariser:
with weights of unit mean activation the paper's factor outweighs the style on all layers but the coarsest.
Views are drawn with one ray a pixel, as the floor of the reprojection is: a smoother picture would be below its floor.
Prints a table with 95 % bootstrap intervals over pictures and says where an order holds: only where intervals do not overlap.
Writes OUT/pictures.html: the same views in all modes, side by side.
"""

import argparse
import concurrent.futures
import html
import json
import math
import os
import pathlib
import random
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
MODES = {"only 2D": "only-2d-scannet", "angle": "angle-scannet", "angle and depth": "stylemesh-scannet"}
LAYERS = {"relu1_1": 1000, "relu2_1": 1000, "relu3_1": 10, "relu4_1": 10, "relu5_1": 1000}

PIPELINE = """version: 1
base: {base}
vars: {{data: {data}, picture: {picture}, weights: {weights}}}
stages:
{scan}
  mesh: {{{mesh_input}max_faces: {faces}}}
  atlas: {{size_px: {size}}}
  texture:
    size_px: {size}
    theta_d_m: {theta_d}
    epochs: {epochs}
    repeats_count: {repeats}
    max_steps: {steps}
    rate: {rate}
    decay: cosine
    init: noise
    lambda_r: 0
    seed: {seed}
    optimiser: {{mode: visible, beta2: 0.99}}
    losses:
      style: {{layers: "{layers}", layer_weights: {layer_weights}}}
      content:
  views: {{type: render.views, input: {{mesh: bake, frames: scan}}, height_px: {height}, samples: 1}}
  glb:
  reprojection:
    type: evaluate.reprojection
    input: {{views: views, frames: scan, textured_mesh: bake}}
    short_gap: {short}
    long_gap: {long}
    every: 4
"""

RECORDED = """  scan: {{type: scan.seven_scenes, path: "${{data}}"}}
  training: {{type: scan.seven_scenes, path: "${{data}}", every: {every}}}
  frames: {{type: frames.sharpest, input: training}}"""

# Looked along, the room is 6 m deep and more.
GENERATED = """  scan: {{type: scan.synthetic_room, length_m: 7.5, width_m: 4, frames_count: 60, keep_unseen: true}}
  frames: {{type: frames.sharpest, input: scan, max_frames: 30}}"""

# Circles of a radius below 10 px do not count: drawn too small, only the largest of the distant ones would.
CIRCLES = """  large_views:
    {{type: render.views, input: {{mesh: bake, frames: scan}}, folder: large_views, height_px: {height}, samples: 1, every_count: {every}}}
  circles: {{type: evaluate.circles, input: {{views: large_views, frames: scan, textured_mesh: bake}}}}
"""


def quoted(path):
    return json.dumps(str(pathlib.Path(path).resolve()))


def has_circles(picture):
    return "circle" in picture.stem


def pipeline(options, mode, picture, seed):
    layers = [layer.strip() for layer in options.layers.split(",")]
    text = PIPELINE.format(
        base=quoted(ROOT / "pipelines/presets" / (MODES[mode] + ".yaml")),
        data=quoted(options.scan or "."),
        picture=quoted(picture),
        weights=quoted(options.weights),
        scan=(RECORDED if options.scan else GENERATED).format(every=options.every),
        mesh_input="" if options.scan else "input: scan, ",
        faces=options.faces,
        size=options.size,
        theta_d=options.theta_d,
        epochs=1 + options.steps // options.repeats,
        repeats=options.repeats,
        steps=options.steps,
        rate=options.rate,
        seed=seed,
        layers=", ".join(layers),
        layer_weights=[LAYERS[layer] for layer in layers],
        height=options.height,
        short=options.short_gap,
        long=options.long_gap,
    )
    if has_circles(picture):
        text += CIRCLES.format(height=options.circle_height, every=options.circles_every)
    return text


def run(options, mode, picture, seed):
    out = options.out / f"{mode.replace(' ', '_')}-{picture.stem}-{seed}"
    out.mkdir(parents=True, exist_ok=True)
    (out / "pipeline.yaml").write_text(pipeline(options, mode, picture, seed))
    begin = time.time()
    cores = max(1, options.cores // options.jobs)
    command = [options.fresco, "run", out / "pipeline.yaml", "--out", out, "--store", options.out / "store", "--cores", str(cores)]
    with open(out / "log.txt", "w") as log:
        code = subprocess.run(command, stdout=log, stderr=log).returncode
    if code:
        raise RuntimeError((out / "log.txt").read_text()[-3000:] + f"\n{mode}, {picture.name}, seed {seed}: exit code {code}")
    print(f"{mode}, {picture.name}, seed {seed}: {time.time() - begin:.0f} s", flush=True)
    figures = {"reprojection": json.loads((out / "reprojection.json").read_text())}
    if has_circles(picture):
        figures["circles"] = json.loads((out / "circles.json").read_text())
    return figures


def pearson(n, x, y, xx, yy, xy):
    spread = (n * xx - x * x) * (n * yy - y * y)
    return (n * xy - x * y) / math.sqrt(spread) if n > 2 and spread > 0 else None


def circle_sums(runs):
    """Of every picture, over the orders: sums of depth d, radius r in pixels and m in metres, and stretch, of its circles."""
    sums = {}
    for one in runs:
        for picture in one["circles"]["picture_circles"]:
            of = sums.setdefault(picture["picture"], [0.0] * 10)
            for circle in picture["circles"]:
                if circle.get("radius_m") is None:
                    continue
                d, r, m = circle["depth_m"], circle["radius_px"], circle["radius_m"]
                for i, value in enumerate((1, d, d * d, r, r * r, d * r, m, m * m, d * m, circle["stretch"])):
                    of[i] += value
    return list(sums.values())


def circle_figures(total):
    n, d, dd, r, rr, dr, m, mm, dm, stretch = total
    return {"Corr2D": pearson(n, d, r, dd, rr, dr), "Corr3D": pearson(n, d, m, dd, mm, dm), "Stretch": stretch / n if n else None}


def pair_sums(runs, gap):
    """Of every source frame, over the orders: sums of the pairs' figures, and their number."""
    sums = {}
    for one in runs:
        for pair in one["reprojection"][gap]["pair_figures"]:
            of = sums.setdefault(pair["source"], [0.0] * 5)
            values = [pair.get(key) for key in ("value", "floor", "sharpness", "headline")]
            if None in values:
                continue
            for i, value in enumerate(values + [1]):
                of[i] += value
    return list(sums.values())


def pair_figures(gap):
    def of(total):
        return {f"{gap} {key}": total[i] / total[4] if total[4] else None
                for i, key in enumerate(("value", "floor", "sharpness", "headline"))}
    return of


def bootstrapped(sums, figures, resamples=2000):
    """The figures of all pictures together, and where 95 % of them lie when pictures are drawn anew (Efron 1979)."""
    draw = random.Random(1)
    drawn = [figures([sum(column) for column in zip(*draw.choices(sums, k=len(sums)))]) for _ in range(resamples)]
    result = {}
    for name, value in figures([sum(column) for column in zip(*sums)]).items():
        known = sorted(one[name] for one in drawn if one[name] is not None)
        low, high = (known[int(0.025 * len(known))], known[int(0.975 * len(known))]) if known else (None, None)
        result[name] = {"value": value if known else None, "low": low, "high": high}
    return result


def over_seeds(runs):
    """Of the same mode and picture, all orders together: a frame is drawn with what every order made of it."""
    merged = bootstrapped(circle_sums(runs), circle_figures) if "circles" in runs[0] else {}
    for gap in ("short", "long"):
        merged.update(bootstrapped(pair_sums(runs, gap), pair_figures(gap)))
    return merged


def cell(figure):
    if figure["value"] is None:
        return "-"
    return f"{figure['value']:.4g} [{figure['low']:.4g}, {figure['high']:.4g}]"


def order(figures):
    """What may be said of one figure of all modes."""
    known = {mode: f for mode, f in figures.items() if f["value"] is not None}
    ranked = sorted(known, key=lambda mode: known[mode]["value"])
    said = [f"{a} < {b}" for a, b in zip(ranked, ranked[1:]) if known[a]["high"] < known[b]["low"]]
    if len(ranked) > 2 and not said and known[ranked[0]]["high"] < known[ranked[-1]]["low"]:
        said = [f"{ranked[0]} < {ranked[-1]}"]
    return ", ".join(said) or "not distinguishable"


def table(title, merged, runs):
    print(f"\n{title}")
    for name in next(iter(merged.values())):
        figures = {mode: merged[mode][name] for mode in merged}
        print(f"  {name:16}" + "".join(f"{cell(figures[mode]):36}" for mode in merged) + order(figures))
    if all("circles" in one for several in runs.values() for one in several):
        counts = {mode: [one["circles"]["circles"] for one in several] for mode, several in runs.items()}
        print("  circles         " + "".join(f"{' + '.join(map(str, counts[mode])):36}" for mode in merged))


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
    parser.add_argument("--seeds", type=int, default=3, help="orders of the frames for circle pictures")
    parser.add_argument("--layers", default="relu1_1, relu2_1, relu3_1", help="style layers that the weights hold")
    parser.add_argument("--modes", default=",".join(MODES), help="some of: " + ", ".join(MODES))
    parser.add_argument("--every", type=int, default=5, help="train with every n-th frame of a scan")
    parser.add_argument("--steps", type=int, default=120)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--rate", type=float, default=8)
    parser.add_argument("--size", type=int, default=2048, help="texels a side")
    parser.add_argument("--faces", type=int, default=500000)
    parser.add_argument("--theta-d", type=float, help="metres; default 0.12 for a scan, 0.25 for the generated room")
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
    for mode in options.modes:
        if mode not in MODES:
            parser.error(f"there is no mode {mode!r}; there are: {', '.join(MODES)}")
    return options


def main():
    options = arguments()
    print(f"{options.steps} steps, {options.repeats} in a row, cosine decay from {options.rate}, {options.size}², "
          f"θ_d {options.theta_d} m, layers {options.layers}", flush=True)
    cases = [(mode, picture, seed) for picture in options.picture
             for seed in range(options.seeds if has_circles(picture) else 1) for mode in options.modes]
    # The first run alone makes what all share.
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
