"""The programs of unrecorded.yaml: `first` takes the first frames of a recording, `compare` compares paint where nothing was
recorded with paint elsewhere."""
import json
import pathlib
import sys

import numpy as np

PATCH = 7
SAMPLES = 6000
KEYS = 16000


def first(count, source, target):
    recording = json.loads((pathlib.Path(source) / "frames.json").read_text())
    recording["frames"] = recording["frames"][: int(count)]
    pathlib.Path(target).mkdir(parents=True, exist_ok=True)
    (pathlib.Path(target) / "frames.json").write_text(json.dumps(recording))


def lab(rgb):
    """CIE L*a*b* of sRGB, uint8 H x W x 3."""
    c = rgb[..., :3] / 255.0
    c = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    to_xyz = np.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]])
    x = c @ to_xyz.T / np.array([0.95047, 1, 1.08883])
    f = np.where(x > 216 / 24389, np.cbrt(x), (24389 / 27 * x + 16) / 116)
    return np.stack([116 * f[..., 1] - 16, 500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])], -1).astype(np.float32)


def shrunk(picture, shorter):
    """By area, to so many pixels along the shorter side."""
    scale = min(picture.shape[:2]) / shorter
    edges = [np.floor(np.arange(round(side / scale) + 1) * scale).astype(int) for side in picture.shape[:2]]
    sums = np.add.reduceat(np.add.reduceat(picture[..., :3].astype(float), edges[0][:-1], 0), edges[1][:-1], 1)
    ends = [np.append(edge[1:-1], side) for edge, side in zip(edges, picture.shape[:2])]
    areas = (ends[0] - edges[0][:-1])[:, None] * (ends[1] - edges[1][:-1])[None]
    return sums / areas[..., None]


def chart_texels(folder, size):
    """Texels with a point of a face in them, by a lattice of points on every face."""
    data = (pathlib.Path(folder) / "mesh.ply").read_bytes()
    header, body = data.split(b"end_header\n", 1)
    types = {b"float": "<f4", b"int": "<i4", b"uchar": "u1", b"uint": "<u4"}
    vertex, face, current, counts = [], [], None, {}
    for line in header.split(b"\n"):
        word = line.split()
        if word[:1] == [b"element"]:
            current = {b"vertex": vertex, b"face": face}[word[1]]
            counts[word[1]] = int(word[2])
        elif word[:2] == [b"property", b"list"]:
            length = 6 if word[4] == b"texcoord" else 3
            current += [(word[4].decode() + "_count", types[word[2]]), (word[4].decode(), types[word[3]], length)]
        elif word[:1] == [b"property"]:
            current.append((word[2].decode(), types[word[1]]))
    faces = np.frombuffer(body, np.dtype(face), counts[b"face"], np.dtype(vertex).itemsize * counts[b"vertex"])
    corners = faces["texcoord"].reshape(-1, 3, 2)
    inside = np.zeros((size, size), bool)
    steps = 12
    for i in range(steps + 1):
        for j in range(steps + 1 - i):
            point = (corners * (np.array([i, j, steps - i - j]) / steps)[None, :, None]).sum(1)
            x, y = np.clip((point * size).astype(int), 0, size - 1).T
            inside[size - 1 - y, x] = True
    return inside


def whole(mask):
    """Where all texels of the patch that begins here are in the mask."""
    sums = np.pad(np.cumsum(np.cumsum(mask.astype(int), 0), 1), ((1, 0), (1, 0)))
    return sums[PATCH:, PATCH:] - sums[:-PATCH, PATCH:] - sums[PATCH:, :-PATCH] + sums[:-PATCH, :-PATCH] == PATCH * PATCH


def patches(picture, places, count, random):
    chosen = random.permutation(len(places))[:count]
    return np.stack([picture[y : y + PATCH, x : x + PATCH].ravel() for y, x in places[chosen]])


def nearest(queries, keys):
    """Mean squared distance per number to the nearest key."""
    squares = (keys**2).sum(1)
    found = [((q**2).sum(1)[:, None] + squares[None] - 2 * q @ keys.T).min(1) for q in np.array_split(queries, 1 + len(queries) // 500)]
    return float(np.concatenate(found).mean() / queries.shape[1])


def changed(before, after, size):
    """Texels whose displayed value depends on a value that differs: those under the bilinear footprint of such a texel of any
    layer."""
    result = np.zeros((size, size), bool)
    for layer in range(len(list(pathlib.Path(after).glob("layer_*.npy")))):
        old, new = (np.load(pathlib.Path(folder) / f"layer_{layer}.npy") for folder in (before, after))
        differs = np.abs(new - old).max(2) > 1e-6
        at = (np.arange(size) + 0.5) * len(differs) / size - 0.5
        for dy in (0, 1):
            for dx in (0, 1):
                index = [np.clip(np.floor(at).astype(int) + d, 0, len(differs) - 1) for d in (dy, dx)]
                result |= differs[np.ix_(*index)]
    return result


def report(rows, name, value):
    print(f"fresco: message {name}: {value:.4f}")
    print(f"fresco: report {name} {value}")
    rows.append([name, value])


def compare(style, photo, initial, optimized, without, result, synthesized, table):
    seen = np.load(pathlib.Path(photo) / "seen.npy") != 0
    size = len(seen)
    charts = chart_texels(result, size)
    rows = []
    report(rows, "unrecorded_share", float((charts & ~seen).sum() / charts.sum()))
    report(rows, "painted_share", float((charts & changed(initial, optimized, size)).sum() / charts.sum()))
    picture = lab(shrunk(np.load(style), 256))
    random = np.random.default_rng(0)
    places = np.argwhere(np.ones((picture.shape[0] - PATCH, picture.shape[1] - PATCH), bool))
    keys = patches(picture, places, KEYS, random)
    for name, folder in (("without", without), ("optimized", result), ("synthesized", synthesized)):
        painted = lab(np.load(pathlib.Path(folder) / "image.npy"))
        there, back, detail = [], [], []
        for mask in (charts & seen, charts & ~seen):
            found = patches(painted, np.argwhere(whole(mask)), SAMPLES, random)
            there.append(nearest(found, keys))
            back.append(nearest(keys[:SAMPLES], found))
            detail.append(float(found[:, ::3].std(1).mean()))
        report(rows, f"{name}_distance_seen", there[0])
        report(rows, f"{name}_distance_ratio", there[1] / there[0])
        report(rows, f"{name}_both_ways_ratio", (there[1] + back[1]) / (there[0] + back[0]))
        report(rows, f"{name}_contrast_ratio", detail[1] / detail[0])
    pathlib.Path(table).write_text(json.dumps({"columns": ["figure", "value"], "rows": rows}))


if __name__ == "__main__":
    {"first": first, "compare": compare}[sys.argv[1]](*sys.argv[2:])
