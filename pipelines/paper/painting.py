#!/usr/bin/env python3
"""painting.py RUN [--picture FILE] [--views FOLDER] [--frames STAGE|none] [--every N] [--path FILE]

Measures whether a painted room looks like its style picture. RUN is the folder with a run's results: its views (`views/*.png`, as
render.views writes them) are compared with the style picture and with what the cameras recorded, both of which run.json names. Prints the
mean and the worst view of each figure and writes them to RUN/painting.json. Needs python3-numpy and python3-opencv.

  off_palette   at most 0.005  share of pixels whose color is farther than 10 (CIE76) from all colors of the picture, rounded to steps of 2
  coherence     0.8 to 1.2     how directed strokes are, view over picture: structure tensor of L* (Gaussian of 1 px, Sobel, Gaussian of
                               3 px), sum of eigenvalue differences over sum of eigenvalue sums
  chroma_noise  0.6 to 1.6     root of the energy of a* and b* over that of L* above a Gaussian of 1 px, view over picture; speckle: 3 to 5
  strokes       at least 0.65  root mean square of L* between Gaussians of 1 px and 4 px, view over picture; recoloring only: 0.4 to 0.6
  edges         at least 0.5   how much of the room is left: correlation of the gradients of L* in view and camera picture at 256 px height
                               after a Gaussian of 3 px

The picture is scaled to 256 px along its shorter side; views are measured at their own size, so compare views of one size. Pixels within
6 px of an uncovered one (alpha is 0) or 8 px of the border are left out; a view with fewer than 5000 pixels left is skipped."""
import argparse
import json
import math
import pathlib
import sys

import cv2
import numpy as np

WANTED = {"off_palette": (None, 0.005), "coherence": (0.8, 1.2), "chroma_noise": (0.6, 1.6), "strokes": (0.65, None), "edges": (0.5, None)}
STYLE_SIDE_PX, EDGES_HEIGHT_PX, LEAST_PIXELS, LEAST_EDGE_PIXELS = 256, 256, 5000, 1000
CELL, REACH = 2, 10
TO_XYZ = np.array([[0.412453, 0.357580, 0.180423], [0.212671, 0.715160, 0.072169], [0.019334, 0.119193, 0.950227]]) / [[0.950456], [1], [1.088754]]
REACH_CELLS = 6  # REACH, for colors that are half a cell off along each axis.


def lab_of(rgb):
    """CIE L*a*b* (D65) of displayed RGB, float32 in 0..1 or uint8. OpenCV's own is a tenth of a unit off, which off_palette shows."""
    rgb = rgb.astype(np.float32) / (255 if rgb.dtype == np.uint8 else 1)
    light = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    t = light @ TO_XYZ.T
    f = np.where(t > 216 / 24389, np.cbrt(t), (24389 / 27 * t + 16) / 116)
    return np.stack([116 * f[..., 1] - 16, 500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])], axis=-1).astype(np.float32)


def blurred(picture, sigma_px):
    return cv2.GaussianBlur(picture, (0, 0), sigma_px, borderType=cv2.BORDER_REFLECT_101)


def eroded(mask, radius_px):
    return cv2.erode(mask.astype(np.uint8), np.ones((2 * radius_px + 1, 2 * radius_px + 1), np.uint8)) > 0


def resized(picture, width, height):
    shrinks = width <= picture.shape[1] and height <= picture.shape[0]
    return cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR)


def read_picture(file):
    """uint8, H x W x 3 or 4."""
    if file.suffix == ".npy":
        pixels = np.load(file)
        pixels = pixels[..., None] if pixels.ndim == 2 else pixels
        return np.repeat(pixels, 3, axis=2) if pixels.shape[2] == 1 else pixels
    flags = cv2.IMREAD_UNCHANGED if file.suffix.lower() == ".png" else cv2.IMREAD_COLOR
    pixels = cv2.imread(str(file), flags)
    if pixels is None:
        sys.exit(f"{file}: cannot be read as a picture")
    if pixels.dtype != np.uint8:
        pixels = (pixels / 257 + 0.5).astype(np.uint8)
    if pixels.ndim == 2:
        return cv2.cvtColor(pixels, cv2.COLOR_GRAY2RGB)
    return cv2.cvtColor(pixels, cv2.COLOR_BGRA2RGBA if pixels.shape[2] == 4 else cv2.COLOR_BGR2RGB)


def on_white(picture):
    if picture.shape[2] == 3:
        return picture
    color, alpha = picture[..., :3].astype(int), picture[..., 3:].astype(int)
    return ((color * alpha + 255 * (255 - alpha) + 127) // 255).astype(np.uint8)


def cells_of(lab):
    low, high = np.array([0, -64, -64]), np.array([50, 64, 64])
    return np.clip(np.rint(lab / CELL).astype(int), low, high) - low + REACH_CELLS


class Palette:
    """The colors of a picture, rounded to cells of L*a*b*."""

    def __init__(self, lab):
        self.has = np.zeros(np.array([51, 129, 129]) + 2 * REACH_CELLS, bool)
        self.has[tuple(cells_of(lab.reshape(-1, 3)).T)] = True
        side = range(-REACH_CELLS, REACH_CELLS + 1)
        steps = [(l, a, b) for l in side for a in side for b in side]
        self.steps = sorted(steps, key=lambda step: sum(at * at for at in step))
        self.steps = np.array([step for step in self.steps if math.hypot(*step) * CELL <= REACH + math.sqrt(3) * CELL / 2])

    def near(self, lab):
        """Which of the colors, N x 3, the picture has within REACH."""
        found, own, left = np.zeros(len(lab), bool), cells_of(lab), np.arange(len(lab))
        for step in self.steps:
            cells = own[left] + step
            away = lab[left] - CELL * (cells - REACH_CELLS + np.array([0, -64, -64]))
            hit = self.has[tuple(cells.T)] & ((away * away).sum(1) <= REACH * REACH)
            found[left[hit]] = True
            left = left[~hit]
            if not len(left):
                break
        return found


def gradients(plane):
    return (cv2.Sobel(plane, cv2.CV_32F, 1, 0, ksize=3, borderType=cv2.BORDER_REFLECT_101),
            cv2.Sobel(plane, cv2.CV_32F, 0, 1, ksize=3, borderType=cv2.BORDER_REFLECT_101))


def appearance(lab, mask):
    """Coherence, chroma noise and strokes of the pixels in the mask."""
    fine, coarse = blurred(lab, 1), blurred(lab[..., 0], 4)
    x, y = gradients(np.ascontiguousarray(fine[..., 0]))
    xx, yy, xy = (blurred(product, 3)[mask].astype(float) for product in (x * x, y * y, x * y))
    detail = ((lab - fine)[mask].astype(float) ** 2).sum(0)
    band = (fine[..., 0] - coarse)[mask].astype(float) ** 2
    ratio = lambda a, b: a / b if b else 0.0 if not a else math.inf
    return (ratio(np.sqrt((xx - yy) ** 2 + 4 * xy ** 2).sum(), (xx + yy).sum()), math.sqrt(ratio(detail[1] + detail[2], detail[0])),
            math.sqrt(band.mean()))


def judged_pixels(covered):
    mask = eroded(covered, 6)
    mask[:8], mask[-8:], mask[:, :8], mask[:, -8:] = False, False, False, False
    return mask


class Style:
    def __init__(self, file):
        rgb = on_white(read_picture(file))
        height, width = rgb.shape[:2]
        lab = lab_of(resized(rgb, *(round(side * STYLE_SIDE_PX / min(width, height)) for side in (width, height))))
        self.palette = Palette(lab)
        self.look = appearance(lab, judged_pixels(np.ones(lab.shape[:2], bool)))
        if self.look[2] < 1e-3:
            sys.exit(f"{file}: the picture has a single color, and so no strokes to compare with")


def lightness(rgb, covered, width, height):
    """L* at another size, where RGB is averaged over covered pixels, and how much of each pixel is covered."""
    weighted = np.dstack([rgb.astype(np.float32) / 255 * covered[..., None], covered.astype(np.float32)])
    weighted = resized(weighted, width, height)
    weight = weighted[..., 3]
    return np.where(weight > 0, lab_of(weighted[..., :3] / np.maximum(weight, 1e-6)[..., None])[..., 0], 0), weight


def edge_correlation(rgb, covered, camera):
    width = max(1, round(rgb.shape[1] * EDGES_HEIGHT_PX / rgb.shape[0]))
    seen, weight = lightness(rgb, covered, width, EDGES_HEIGHT_PX)
    recorded, _ = lightness(camera, np.ones(camera.shape[:2], bool), width, EDGES_HEIGHT_PX)
    mask = eroded(weight > 0.5, 7)
    if mask.sum() < LEAST_EDGE_PIXELS:
        return math.nan
    near = blurred(weight, 3)
    weighed = lambda plane: np.where(near > 0, blurred(plane * weight, 3) / np.maximum(near, 1e-12), 0).astype(np.float32)
    a, b = (np.concatenate([part[mask] for part in gradients(weighed(plane))]).astype(float) for plane in (seen, recorded))
    return float(np.corrcoef(a, b)[0, 1]) if a.std() > 0 and b.std() > 0 else math.nan


def judge(view, style, camera):
    """{figure: value}; None for a view that shows too little."""
    rgb = np.ascontiguousarray(view[..., :3])
    covered = view[..., 3] > 0 if view.shape[2] == 4 else view.astype(int).sum(2) > 5
    mask = judged_pixels(covered)
    if mask.sum() < LEAST_PIXELS:
        return None
    lab = lab_of(rgb)
    # Every color is looked up once.
    colors, counts = np.unique(rgb[mask], axis=0, return_counts=True)
    near = style.palette.near(lab_of(colors[None])[0])
    found = {"off_palette": counts[~near].sum() / mask.sum()}
    for name, own, wanted in zip(("coherence", "chroma_noise", "strokes"), appearance(lab, mask), style.look):
        found[name] = own / wanted if wanted > 1e-3 else math.nan
    found["edges"] = edge_correlation(rgb, covered, camera) if camera is not None else math.nan
    return {name: float(value) for name, value in found.items() if math.isfinite(value)}


class Run:
    """What run.json says of the picture and of the frames."""

    def __init__(self, folder):
        file = folder / "run.json"
        if not file.exists():
            sys.exit(f"{file}: no such file; name the folder with a run's results")
        self.data = json.loads(file.read_text())
        self.stages = {name: stage for stage in self.data["stages"] for name in (stage["name"], stage["own_name"])}

    def picture(self):
        for stage in self.data["stages"]:
            for wire in stage["inputs"]:
                if wire["port"] == "style" and "file" in wire:
                    return pathlib.Path(self.data["directory"], wire["file"])
        sys.exit("run.json names no style picture: set --picture")

    def camera_pictures(self, stage):
        """{view: file of the camera's picture}, of the stage's frames, or of those that the views were rendered from."""
        wires = [(stage, "frames")] if stage else [(wire["stage"], wire["output"]) for one in self.data["stages"] for wire in one["inputs"]
                                                   if one["type"] == "render.views" and wire["port"] == "frames" and "stage" in wire]
        if not wires or wires[0][0] not in self.stages:
            sys.exit("run.json has no such frames: set --frames STAGE, or --frames none to go without 'edges'")
        store = pathlib.Path(self.data["store"])
        folder = store / "objects" / self.stages[wires[0][0]]["object"] / wires[0][1]
        if not folder.is_dir():
            sys.exit(f"{folder}: the frames are not in the store: run the pipeline again, or set --frames none")
        base = {"own": folder, "store": store, "file": pathlib.Path("/")}
        files = {}
        for frame in json.loads((folder / "frames.json").read_text())["frames"]:
            if frame["color_picture"]:
                place, _, name = frame["color_picture"]["ref"].partition(":")
                files[f"{frame['sequence']}_{frame['name']}"] = base[place] / name
        return files


def summary(views):
    """Mean and worst view of each figure that was measured."""
    figures = {}
    for name, (low, high) in WANTED.items():
        values = {view: found[name] for view, found in views.items() if found and name in found}
        if not values:
            continue
        bad = lambda value: max((low if low is not None else -math.inf) - value, value - (high if high is not None else math.inf))
        worst = max(values, key=lambda view: bad(values[view]))
        mean = sum(values.values()) / len(values)
        figures[name] = {"mean": mean, "worst": values[worst], "worst_view": worst}
        figures[name] |= {key: end for key, end in (("at_least", low), ("at_most", high)) if end is not None}
        figures[name]["reached"] = bad(mean) <= 0
    return figures


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, usage=argparse.SUPPRESS)
    parser.add_argument("run", type=pathlib.Path, help="folder with a run's results")
    parser.add_argument("--picture", type=pathlib.Path, help="the style picture, instead of the one that run.json names")
    parser.add_argument("--views", default="views", help="folder of the views below RUN")
    parser.add_argument("--frames", help="stage with the frames; none: without 'edges'")
    parser.add_argument("--every", type=int, default=1, help="judge only every n-th view")
    parser.add_argument("--path", default="painting.json", help="the file to write, below RUN")
    given = parser.parse_args()
    run = Run(given.run)
    style = Style(given.picture or run.picture())
    cameras = None if given.frames == "none" else run.camera_pictures(given.frames)
    files = sorted(file for file in (given.run / given.views).glob("*") if file.suffix.lower() in (".png", ".jpg", ".jpeg"))
    files = [file for file in files if cameras is None or file.stem in cameras][::given.every]
    if not files:
        sys.exit(f"{given.run / given.views}: no pictures, or none of the frames")
    views = {}
    for file in files:
        camera = read_picture(cameras[file.stem])[..., :3] if cameras else None
        views[file.stem] = judge(read_picture(file), style, camera)
    skipped = sum(found is None for found in views.values())
    if skipped == len(views):
        sys.exit(f"none of the {len(views)} views shows enough of the room: each needs {LEAST_PIXELS} pixels that are 6 px away from "
                 "uncovered ones; render larger views")
    figures = summary(views)
    result = {"figures": figures, "views": len(views) - skipped, "views_skipped": skipped,
              "view_figures": [{"view": view} | ({"skipped": True} if found is None else found) for view, found in views.items()]}
    (given.run / given.path).write_text(json.dumps(result, indent=1) + "\n")
    for name, figure in figures.items():
        print(f"{name:13} {figure['mean']:.3f}  worst {figure['worst']:.3f} in {figure['worst_view']}{'' if figure['reached'] else '  not reached'}")


main()
