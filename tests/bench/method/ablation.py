#!/usr/bin/env python3
"""The paper's ablation, shortened: only 2D, angle, angle and depth, on one scan with one schedule.

Needs a built fresco. Every run is a pipeline over the preset of its mode; what runs share is stored once. Prints a table with
95 % bootstrap intervals over pictures and says where an order holds: only where intervals do not overlap.
"""

import argparse
import json
import pathlib
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
  scan: {{type: scan.seven_scenes, path: "${{data}}"}}
  training: {{type: scan.seven_scenes, path: "${{data}}", every: {every}}}
  frames: {{type: frames.sharpest, input: training}}
  mesh: {{max_faces: {faces}}}
  atlas: {{size_px: {size}}}
  texture:
    size_px: {size}
    theta_d_m: {theta_d}
    epochs: {epochs}
    repeats_count: {repeats}
    max_steps: {steps}
    rate: {rate}
    decay: cosine
    seed: {seed}
    optimiser: {{mode: visible, beta2: 0.99}}
    losses:
      style: {{layers: "{layers}", layer_weights: {layer_weights}}}
      content:
  views: {{type: render.views, input: {{mesh: bake, frames: scan}}, height_px: {height}}}
  glb:
  reprojection:
    type: evaluate.reprojection
    input: {{views: views, frames: scan, textured_mesh: bake}}
    short_gap: {short}
    long_gap: {long}
"""

CIRCLES = """  circles:
    type: evaluate.circles
    input: {views: views, frames: scan, textured_mesh: bake}
"""


def quoted(path):
    return json.dumps(str(pathlib.Path(path).resolve()))


def run(options, mode, picture, seed):
    out = options.out / f"{mode.replace(' ', '_')}-{picture.stem}-{seed}"
    out.mkdir(parents=True, exist_ok=True)
    layers = [layer.strip() for layer in options.layers.split(",")]
    text = PIPELINE.format(
        base=quoted(ROOT / "pipelines/presets" / (MODES[mode] + ".yaml")),
        data=quoted(options.scan),
        picture=quoted(picture),
        weights=quoted(options.weights),
        every=options.every,
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
    if "circle" in picture.stem:
        text += CIRCLES
    (out / "pipeline.yaml").write_text(text)
    begin = time.time()
    with open(out / "log.txt", "w") as log:
        code = subprocess.run(
            [options.fresco, "run", out / "pipeline.yaml", "--out", out, "--store", options.out / "store"], stdout=log, stderr=log
        ).returncode
    if code:
        sys.exit((out / "log.txt").read_text()[-3000:] + f"\n{mode}, {picture.name}, seed {seed}: exit code {code}")
    print(f"{mode}, {picture.name}, seed {seed}: {time.time() - begin:.0f} s", flush=True)
    figures = {"reprojection": json.loads((out / "reprojection.json").read_text())}
    if (out / "circles.json").exists():
        figures["circles"] = json.loads((out / "circles.json").read_text())
    return figures


def rows(figures):
    """(name, figure) of one run; a figure has value, low and high."""
    circles = figures.get("circles", {})
    for key, name in (("corr_2d", "Corr2D"), ("corr_3d", "Corr3D"), ("stretch", "Stretch")):
        if key in circles:
            yield name, circles[key]
    for gap in ("short", "long"):
        for key in ("value", "floor", "sharpness", "headline"):
            yield f"{gap} {key}", figures["reprojection"][gap][key]


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


def table(title, results):
    print(f"\n{title}")
    names = [name for name, _ in rows(next(iter(results.values())))]
    values = {mode: dict(rows(figures)) for mode, figures in results.items()}
    for name in names:
        figures = {mode: values[mode][name] for mode in results}
        print(f"  {name:16}" + "".join(f"{cell(figures[mode]):36}" for mode in results) + order(figures))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scan", required=True, type=pathlib.Path, help="folder in the layout of 7-Scenes")
    parser.add_argument("--weights", required=True, type=pathlib.Path, help="VGG-19")
    parser.add_argument("--picture", required=True, type=pathlib.Path, action="append", help="a name with 'circle' is measured as such")
    parser.add_argument("--seeds", type=int, default=3, help="orders of the frames for circle pictures")
    parser.add_argument("--layers", default="relu1_1, relu2_1, relu3_1", help="style layers that the weights hold")
    parser.add_argument("--modes", default=",".join(MODES), help="some of: " + ", ".join(MODES))
    parser.add_argument("--every", type=int, default=5, help="train with every n-th frame")
    parser.add_argument("--steps", type=int, default=120)
    parser.add_argument("--repeats", type=int, default=4)
    parser.add_argument("--rate", type=float, default=5)
    parser.add_argument("--size", type=int, default=2048, help="texels a side")
    parser.add_argument("--faces", type=int, default=500000)
    parser.add_argument("--theta-d", type=float, default=0.12, help="metres")
    parser.add_argument("--height", type=int, default=784, help="of the rendered views")
    parser.add_argument("--short-gap", type=int, default=8)
    parser.add_argument("--long-gap", type=int, default=24)
    parser.add_argument("--fresco", default=ROOT / "build/bin/fresco", type=pathlib.Path)
    parser.add_argument("--out", default=ROOT / "build/ablation", type=pathlib.Path)
    options = parser.parse_args()
    modes = [mode.strip() for mode in options.modes.split(",")]
    for mode in modes:
        if mode not in MODES:
            parser.error(f"there is no mode {mode!r}; there are: {', '.join(MODES)}")
    print(f"{options.steps} steps, {options.repeats} in a row, cosine decay from {options.rate}, {options.size}², "
          f"θ_d {options.theta_d} m, layers {options.layers}", flush=True)
    for picture in options.picture:
        for seed in range(options.seeds if "circle" in picture.stem else 1):
            results = {mode: run(options, mode, picture, seed) for mode in modes}
            table(f"{picture.name}, order {seed}: " + " | ".join(modes), results)
    return 0


if __name__ == "__main__":
    sys.exit(main())
