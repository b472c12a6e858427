#!/usr/bin/env python3
"""one_step.py PROTOCOL STORE DATASET WEIGHTS BEFORE AFTER: the first step of texture.optimize, computed once more in float64, from the paper or,
with the protocol `released`, from the table in texture.optimize's README.

BEFORE and AFTER are logs of `fresco run --json-log`: a run at rate 0, whose texture is the one that the step begins with, and one at RATE
with Adam's epsilon 1, from whose change the gradient follows. DATASET is what dataset.write made of the same uv maps, frames and style.
Lookup, network and losses are written out here, and PyTorch differentiates them.
"The paper" is StyleMesh (Höllein, Johnson, Nießner, CVPR 2022).
"""
import json
import pathlib
import struct
import sys

import cv2
import numpy as np
import torch
from fresco.rasters import read_raster

# The paper's constants, but for the length that has the smallest height, which is more because the pictures are smaller.
THETA_MIN_PX, THETA_D_M, ANGLE_LIMIT_DEG = 32, 1.6, 30
RELEASED = sys.argv[1:2] == ["released"]
CONTENT_WEIGHT, STYLE_WEIGHT, REGULARIZER_WEIGHT = (0.7, 1e-6, 50) if RELEASED else (70, 1e-4, 5000)  # so that few texels are clamped
STYLE_LAYERS = {"1_1": 1000, "2_1": 1000, "3_1": 10, "4_1": 10, "5_1": 1000}
FINE_LAYERS = ("4_1", "5_1") if RELEASED else tuple(STYLE_LAYERS)  # that the fine target is for
CONTENT_LAYER = "4_2"
REGULARIZER_FACTORS = (8, 4, 2, 0)
MEAN_BGR = np.array([103.939, 116.779, 123.68])
LEAST, MOST = -123.68, 255 - 103.939  # that a texel of the released code may store
LAYERS = [f"{block}_{number}" for block, count in ((1, 2), (2, 2), (3, 4), (4, 4), (5, 1)) for number in range(1, count + 1)]

RATE = 30 if RELEASED else 1000  # of the second run


# The network, VGG-19 with zero padding. Pictures and maps are H x W x C.


def read_weights(path):
    """The convolutions of a safetensors file: name to filters and biases."""
    data = pathlib.Path(path).read_bytes()
    start = 8 + struct.unpack_from("<Q", data)[0]
    header = json.loads(data[8:start])

    def tensor(name):
        begin, end = header[name]["data_offsets"]
        return torch.from_numpy(np.frombuffer(data[start + begin : start + end], np.float16).reshape(header[name]["shape"]).astype(np.float64))

    return {name: (tensor(f"conv{name}.weight"), tensor(f"conv{name}.bias")) for name in LAYERS}


def encode(picture, last="5_1"):
    """The rectified features up to `last`, by name. `picture` is BGR in 0..255 minus the mean."""
    features, maps = {}, torch.as_tensor(picture).permute(2, 0, 1)[None]
    for name in LAYERS[: LAYERS.index(last) + 1]:
        if name in ("2_1", "3_1", "4_1", "5_1"):
            maps = torch.nn.functional.max_pool2d(maps, 2)
        maps = torch.relu(torch.nn.functional.conv2d(maps, *WEIGHTS[name], padding=1))
        features[name] = maps[0].permute(1, 2, 0)
    return features


# The losses of one level (the paper, section 3.4). Every norm is a mean over the elements.


def on_grid(mask, name):
    """A mask of pixels on a layer's grid: each cell takes the pixel at its center, with the released code at its corner."""
    stride = 2 ** (int(name[0]) - 1)
    if RELEASED:
        return from_corners(mask, [size // stride for size in mask.shape])
    rows, columns = (np.arange(size // stride) * stride + stride // 2 for size in mask.shape)
    return mask[np.ix_(rows, columns)]


def from_corners(values, shape):
    """Resampled by the pixels under the upper left corners of those of `shape`, computed in single precision."""
    rows, columns = (np.floor(np.arange(new, dtype=np.float32) * (np.float32(old) / np.float32(new))).astype(int) for new, old in zip(shape, values.shape))
    return values[np.ix_(rows, columns)]


def gram(selected):
    """N x C features to C x C."""
    return selected.T @ selected / len(selected)


def level_losses(picture, camera, pixels, roles, shares):
    """Style and content, weighted. `camera`: the content layer's features. `roles`: masks of pixels, with the Gram matrices that these are
    compared with, and whether they are even where a layer has no cell of them. `shares`: the level's, for each layer."""
    features = encode(picture)
    style = content = torch.zeros(())
    for mask, targets, always in roles:
        for name, target in targets.items():
            chosen = torch.from_numpy(on_grid(mask, name))
            if always or chosen.any():  # Where there is no cell, zeros are compared.
                found = gram(features[name][chosen]) if chosen.any() else torch.zeros(())
                style = style + STYLE_WEIGHT * STYLE_LAYERS[name] * shares[name] * ((found - target) ** 2).mean()
    chosen = torch.from_numpy(on_grid(pixels, CONTENT_LAYER))
    if chosen.any():
        content = CONTENT_WEIGHT * shares[CONTENT_LAYER] * ((features[CONTENT_LAYER] - camera)[chosen] ** 2).mean()
    return style, content


# The texture, a pyramid of layers whose lookups are summed (the paper, section 3.1).


def look_up(layers, uv):
    """The sum of the layers at each texcoord, before it is clamped: bilinear, texel centers at +0.5, row 0 at v = 1."""
    total = 0
    for layer in layers:
        place = np.clip(np.stack([uv[:, 0], 1 - uv[:, 1]], 1).astype(np.float64) * len(layer) - 0.5, 0, len(layer) - 1)
        low = np.minimum(place.astype(int), len(layer) - 2)
        for y, x in np.ndindex(2, 2):
            share = (1 - np.abs(low + (x, y) - place)).prod(1, keepdims=True)
            total = total + layer[low[:, 1] + y, low[:, 0] + x] * torch.from_numpy(share)
    return total


# Which pixels belong to which level (the paper, sections 3.2 and 3.5).


def erode(mask):
    """3 x 3; outside the image is background."""
    return cv2.erode(mask.astype(np.uint8), np.ones((3, 3)), borderType=cv2.BORDER_CONSTANT, borderValue=0) == 1


def nearest(values, shape):
    """Resampled by nearest neighbor."""
    if RELEASED:
        return from_corners(values, shape)
    rows, columns = (((np.arange(new) + 0.5) * old / new).astype(int) for new, old in zip(shape, values.shape))
    return values[np.ix_(rows, columns)]


def depth_levels(view, heights):
    """For each height the mask of its pixels and the weight of their gradients; `view`, and these, are of the smallest height."""
    heights = np.array(heights)
    ideal = THETA_MIN_PX * view["depth"].astype(np.float64) / THETA_D_M
    first = np.abs(ideal[..., None] - heights).argmin(-1)
    second = np.clip(first + np.sign(ideal - heights[first]).astype(int), 0, len(heights) - 1)
    gap = np.abs(heights[first] - heights[second])
    share = np.where(gap > 0, 1 - np.abs(ideal - heights[first]) / np.maximum(gap, 1), 1)
    for level in range(len(heights)):
        nearer, farther = view["valid"] & (first == level), view["valid"] & (second == level) & (RELEASED | (share < 1))
        yield erode(nearer | farther), erode(nearer) * share + erode(farther) * (1 - share)


# One step.


def shrink(picture, shape):
    """Averaged by area to `shape`, H x W."""
    return cv2.resize(picture.astype(np.float64), shape[1::-1], interpolation=cv2.INTER_AREA)


def linear(values, shape):
    """Resampled to `shape`, H x W, between the centers of cells."""
    result = values.astype(np.float64)
    for axis, (new, old) in enumerate(zip(shape, values.shape)):
        place = np.clip((np.arange(new) + 0.5) * old / new - 0.5, 0, old - 1)
        share = np.maximum(0, 1 - np.abs(place[:, None] - np.arange(old)))
        result = np.moveaxis(np.tensordot(share, result, (1, axis)), 0, axis)
    return result


def bicubic(picture, shape):
    """Keys' cubic convolution to `shape`, H x W, as Pillow has it: widened where it reduces, rounded to 8 bits after each axis, rows first."""
    result = picture
    for axis in (1, 0):
        old, new = picture.shape[axis], shape[axis]
        wide = max(old / new, 1)
        center = (np.arange(new)[:, None] + 0.5) * old / new
        taps, away = np.arange(old), np.abs((np.arange(old) + 0.5 - center) / wide)
        share = np.where(away < 1, (1.5 * away - 2.5) * away**2 + 1, np.where(away < 2, ((away - 5) * away + 8) * away * -0.5 + 2, 0))
        share *= (taps >= (center - 2 * wide + 0.5).astype(int)) & (taps < (center + 2 * wide + 0.5).astype(int))
        whole = np.tensordot(share / share.sum(1, keepdims=True), result.astype(np.float64), (1, axis))
        result = np.moveaxis(np.clip(np.floor(whole + 0.5), 0, 255), 0, axis)
    return result


def as_released(views):
    """The smallest view as the released loader for ScanNet makes it: from exported pictures and depth, with the largest one's surface."""
    smallest, large = views[0], views[-1]["valid"]
    picture, depth = (full[np.ix_(*(np.arange(new) * old // new for new, old in zip((240, 320), full.shape)))] for full in (smallest["full"], smallest["sensor"]))
    rows, columns = (((np.arange(new) + 0.5) * old / new).astype(int) for new, old in zip(smallest["valid"].shape, large.shape))
    valid = (large & (linear(depth, large.shape) > 0))[np.ix_(rows, columns)]
    return smallest | {"valid": valid, "depth": linear(depth, valid.shape), "color": bicubic(picture, valid.shape)}


def as_input(rgb):
    """RGB in 0..255 to what the network takes."""
    return rgb[..., ::-1].astype(np.float64) - MEAN_BGR


def style_grams(rgb):
    """The Gram targets of one size of the style picture."""
    return {name: gram(maps.flatten(0, 1)) for name, maps in encode(as_input(rgb)).items() if name in STYLE_LAYERS}


def level_step(view, layers, masks, weight, cosine, shares, camera, targets):
    """The level's losses; adds their gradient to that of the layers (the paper, sections 3.3 and 3.5)."""
    valid, (pixels, fine), (coarse, of_fine) = view["valid"], masks, targets
    of_fine = {name: of_fine[name] for name in FINE_LAYERS}
    roles = [(fine, coarse, True), (pixels & ~fine, coarse, False), (fine, of_fine, True)] if RELEASED else [(pixels, coarse, False), (fine, of_fine, False)]
    uv = view["uv"]
    if RELEASED:  # The first texel is what is seen where there is no surface.
        uv, valid = np.where(valid[..., None], uv, (0.0, 1.0)), np.ones_like(valid)
    stored = look_up(layers, uv[valid])
    least, most = torch.from_numpy(-MEAN_BGR), torch.from_numpy(255 - MEAN_BGR)
    picture = least.repeat(*valid.shape, 1)  # black where there is no surface
    picture[valid] = stored.detach() if RELEASED else torch.clamp(stored.detach(), least, most)
    losses = level_losses(picture.requires_grad_(), camera, pixels, roles, shares)
    sum(losses).backward()
    gradient = picture.grad[valid] * torch.from_numpy((cosine * weight)[valid])[:, None]
    if not RELEASED:  # Where a value is beyond what can be displayed, only a step that leads back counts.
        gradient[(stored > most) & (gradient < 0) | (stored < least) & (gradient > 0)] = 0
    stored.backward(gradient)
    return np.array([float(loss) for loss in losses])


def step(views, layers, targets):
    """Style and content, and for every layer their gradient and the regularizer's."""
    levels, smallest = [], np.maximum(views[0]["cosine"].astype(np.float64), 0)
    first = as_released(views) if RELEASED else views[0]
    for view, (mask, weight) in zip(views, depth_levels(first, [len(view["valid"]) for view in views])):
        shape = view["valid"].shape
        pixels = nearest(mask, shape) & (RELEASED | view["valid"])
        if RELEASED:
            cosine, passes = linear(smallest, shape), linear(np.degrees(np.arccos(np.minimum(smallest, 1))), shape) < ANGLE_LIMIT_DEG
        else:
            cosine = np.maximum(view["cosine"].astype(np.float64), 0)
            passes = cosine >= np.cos(np.radians(ANGLE_LIMIT_DEG))
        levels.append(((pixels, pixels & passes), nearest(weight, shape), cosine))
    cover = [{name: (on_grid(masks[0], name) if RELEASED else masks[0]).mean() for name in (*STYLE_LAYERS, CONTENT_LAYER)} for masks, _, _ in levels]
    sums = {name: sum(level[name] for level in cover) for name in cover[0]}
    layers, losses = [torch.tensor(layer, requires_grad=True) for layer in layers], np.zeros(2)
    for view, (masks, weight, cosine), level in zip(views, levels, cover):
        shares = {name: level[name] / sums[name] for name in level}
        camera = encode(as_input((first if RELEASED else view)["color"]), CONTENT_LAYER)[CONTENT_LAYER]
        if RELEASED:
            camera = torch.from_numpy(linear(camera.numpy(), [size // 8 for size in weight.shape]))
        losses += level_step(view, layers, masks, weight, cosine, shares, camera, targets)
    factors = [REGULARIZER_WEIGHT * factor * 2 / layer.numel() for layer, factor in zip(layers, REGULARIZER_FACTORS)]
    return losses, [layer.grad.numpy() for layer in layers], [factor * layer.detach().numpy() for layer, factor in zip(layers, factors)]


# What fresco made of it.


def read_run(store, log):
    """The texture's layers and the report of the stage `texture`."""
    events = [json.loads(line) for line in log.read_text().splitlines() if line.startswith("{")]
    made = store / "objects" / next(event["object"] for event in events if event["event"] == "end" and event["stage"] == "texture")
    layers = [read_raster(made / f"texture/layer_{i}.packed").astype(np.float64) for i in range(len(REGULARIZER_FACTORS))]
    return layers, json.loads((made / "manifest.json").read_text())["report"]


def read_view(folder, height):
    """A view's maps at a height, and its camera picture, which is averaged to that height in whole steps."""
    view = {name: np.load(folder / f"{name}_{height}.npy") for name in ("uv", "depth", "cosine", "valid", "color")}
    full = np.load(folder / "color.npy")
    assert np.abs(shrink(full, view["valid"].shape) - view["color"]).max() < 0.501, "the camera picture"
    return view | {"valid": view["valid"] == 1, "full": full, "sensor": np.load(folder / "sensor_depth.npy") / 1000}


def distance(theirs, ours):
    """Relative, in the L2 norm."""
    return np.linalg.norm(np.subtract(theirs, ours)) / max(np.linalg.norm(ours), 1e-30)


def gradient_distances(layer, new, ours, regularizer):
    """How far a layer's gradient is off where the view sees it, and elsewhere, where only the regularizer acts.

    An activation that float32 cannot tell from zero, or from another one of its 2 x 2, may send its gradient another way than here. One
    such is enough for some parts in a thousand on the texels around; hence not every texel has to agree as closely as the losses.
    """
    moved = (layer - new) / RATE
    theirs = moved / (1 - np.abs(moved))  # Adam's first step with epsilon 1 is rate * g / (|g| + 1).
    seen = (ours != 0).any(1)
    ours = ours + regularizer
    if RELEASED:  # What was clamped after the step says nothing of the gradient.
        expected = layer - RATE * ours / (np.abs(ours) + 1)
        inside = ((expected > LEAST) & (expected < MOST)).all(1)
        yield "the values that are clamped", np.abs(new - np.clip(expected, LEAST, MOST))[~inside].max(initial=0), 1e-3
        theirs, ours, seen = theirs[inside], ours[inside], seen[inside]
    sizes = np.linalg.norm(ours[seen], axis=1)
    median, most = np.quantile(np.linalg.norm((theirs - ours)[seen], axis=1) / sizes, (0.5, 0.9))
    yield "half of the texels seen", median, 2e-3
    yield "nine tenths of the texels seen", most, 2e-2
    yield "all texels seen", distance(theirs[seen], ours[seen]), 1e-2
    yield "the texels not seen", distance(theirs[~seen], ours[~seen]), 1e-4


def main():
    global WEIGHTS
    store, dataset, weights, before, after = map(pathlib.Path, sys.argv[2:])
    WEIGHTS = read_weights(weights)
    layers, _ = read_run(store, before)
    stepped, report = read_run(store, after)
    views = [read_view(dataset / "views/000000", height) for height in json.loads((dataset / "dataset.json").read_text())["heights_px"]]
    coarse = np.load(dataset / "style.npy")  # four times as large as fine, whose shorter side is 256 px, but no larger than the picture
    fine = (linear if RELEASED else shrink)(coarse, [round(256 * size / min(coarse.shape[:2])) for size in coarse.shape[:2]])

    (style, content), gradients, regularizers = step(views, layers, (style_grams(coarse), style_grams(fine)))

    found = report["losses_at_last_step"]
    print(f"style {found['style']:.8g} for {style:.8g}, content {found['content']:.8g} for {content:.8g}")
    results = [
        ("style loss", distance(found["style"], style), 1e-4),
        ("content loss", distance(found["content"], content), 1e-4),
        ("initial style over content", distance(report["initial_style_over_content"], style / content), 1e-4),
    ]
    for number, (layer, new, gradient, regularizer) in enumerate(zip(layers, stepped, gradients, regularizers)):
        for name, apart, allowed in gradient_distances(*(values.reshape(-1, 3) for values in (layer, new, gradient, regularizer))):
            results.append((f"layer {number}, gradient of {name}", apart, allowed))
    for name, apart, allowed in results:
        print(f"{'' if apart <= allowed else 'WRONG: '}{name}: {apart:.1e} apart, {allowed:g} allowed")
    sys.exit(any(not apart <= allowed for _, apart, allowed in results))


if __name__ == "__main__":
    main()
