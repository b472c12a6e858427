#!/usr/bin/env python3
"""One step of `stylemesh-released-scannet` beside the same step of the program that the authors of StyleMesh released.

Needs a built fresco, a scan in the layout of 7-Scenes, a checkout of github.com/lukasHoel/stylemesh, and Debian's python3-torch,
python3-torchvision, python3-opencv and python3-pil. Their model/optimize.py runs as it is, on the CPU, on the folder that `dataset.write`
makes (layout: stylemesh), with the same random VGG-19 and the same picture. Lightning is replaced by the few lines that it comes down to.

fresco takes ten steps and one more; theirs begins with fresco's texture before the last, so that both take the same step. Not the
first one: at a flat texture max pooling has ties everywhere, and the gradient depends on how convolutions round.
"""

import argparse
import contextlib
import json
import pathlib
import runpy
import signal
import struct
import subprocess
import sys
import tempfile
import types

import numpy as np
import torch

ROOT = pathlib.Path(__file__).resolve().parents[3]
LAYERS, FRAMES, STEPS, SIZE_PX = 4, 5, 10, 1024
PIPELINE = """version: 1
base: {base}
vars: {{data: {scan}, picture: {picture}, weights: {folder}/vgg.pth}}
stages:
  scan: {{type: scan.recording, path: "${{data}}"}}
  frames: {{min_sharpness: 0, window_count: 1, max_frames: {frames}}}
  mesh: {{max_faces: 20000}}
  atlas: {{size_px: {size}}}
  dataset: {{type: dataset.write, input: {{uvmaps: uvmaps, frames: frames, mesh: atlas}}, layout: stylemesh}}
  texture: {{theta_d_m: {theta_d_m}, checkpoint_steps: 1}}
"""


def random_weights(path):
    """All convolutions of VGG-19 under the keys of the original weights, which neither program rescales."""
    torch.manual_seed(1)
    state, inputs = {}, 3
    for block, (outputs, count) in enumerate(((64, 2), (128, 2), (256, 4), (512, 4), (512, 4)), 1):
        for number in range(1, count + 1):
            weight = torch.randn(outputs, inputs, 3, 3) * (2 / (9 * inputs)) ** 0.5
            # No common mean: it would outweigh what differs between places.
            state[f"conv{block}_{number}.weight"] = weight - weight.mean((1, 2, 3), keepdim=True)
            state[f"conv{block}_{number}.bias"] = torch.randn(outputs)
            inputs = outputs
    torch.save(state, path, _use_new_zipfile_serialization=False)


def read_safetensors(path):
    data = path.read_bytes()
    start = 8 + struct.unpack_from("<Q", data)[0]
    header = json.loads(data[8:start])
    types_of = {"F32": np.float32, "I64": np.int64}
    return {name: np.frombuffer(data[start + entry["data_offsets"][0] : start + entry["data_offsets"][1]], types_of[entry["dtype"]])
            for name, entry in header.items() if name != "__metadata__" and entry["dtype"] in types_of}


def our_step(options, folder):
    """Of the step after STEPS steps or a little later: the layers before it, their gradients, each C x H x W, and the loss.

    The run is interrupted there, which leaves the checkpoints of its last two steps; a gradient follows from Adam's first moments."""
    command = [options.fresco, "run", folder / "step.yaml", "--until", "texture", "--store", folder / "store", "--out", folder / "out", "--json-log"]
    process, losses = subprocess.Popen(command, stdout=subprocess.PIPE, text=True), {}
    for line in process.stdout:
        event = json.loads(line) if line.startswith("{") else {}
        if event.get("event") == "progress" and event.get("unit") == "steps":
            if not losses and event["done"] > STEPS:
                process.send_signal(signal.SIGINT)
            if event["done"] > STEPS:
                losses[event["done"]] = event["metrics"]["loss"]
    if process.wait() != 75:
        sys.exit(f"fresco ended with {process.returncode} instead of being interrupted")
    states = sorted((read_safetensors(file) for file in folder.glob("store/checkpoints/**/*.safetensors")), key=lambda state: state["rule/step"][0])
    before, after = states[-2:]
    step = int(after["rule/step"][0])
    if step not in losses or before["rule/step"][0] != step - 1:
        sys.exit(f"fresco reported the losses of steps {sorted(losses)} and kept its states after {[int(s['rule/step'][0]) for s in states]}: run again")

    def planes(values):
        side = round((values.size / 3) ** 0.5)
        return values.reshape(side, side, 3).transpose(2, 0, 1)

    layers = [planes(before[f"parameter/layer_{i}"]) for i in range(LAYERS)]
    moments = [[planes(state[f"rule/first.{i}"]).astype(np.float64) for i in range(LAYERS)] for state in (before, after)]
    return layers, [(new - 0.9 * old) / 0.1 for old, new in zip(*moments)], losses[step]


def stand_in(name, **contents):
    module = sys.modules[name] = types.ModuleType(name)
    module.__dict__.update(contents)


def their_step(layers, options, folder):
    """The gradient of each layer and the loss, of one step of the authors' program that begins with `layers`."""
    result = {}

    class Trainer:
        logger = types.SimpleNamespace(save_dir=str(folder), version=0)

        @staticmethod
        def add_argparse_args(parser):
            return parser

        @classmethod
        def from_argparse_args(cls, _):
            return cls()

        @staticmethod
        def fit(model, data):
            for layer, values in zip(model.texture.layers, layers):
                layer.data.data.copy_(torch.from_numpy(values.copy()))
            model.on_train_epoch_start()
            loss = model.training_step(next(iter(data.train_dataloader())), 0)["loss"]
            loss.backward()
            style, content = (float(model.loss_history[name]["train"][-1]) for name in ("style", "content"))
            result.update(loss=style + content, gradients=[layer.data.grad.numpy().astype(np.float64) for layer in model.texture.layers])
            raise StopIteration  # it would render now

    silent = types.SimpleNamespace(**{f"add_{what}": lambda *_: None for what in ("scalar", "scalars", "image")})
    lightning_module = type("LightningModule", (torch.nn.Module,), {"current_epoch": 0, "logger": types.SimpleNamespace(experiment=silent),
                                                                     "save_hyperparameters": lambda *_: None})
    stand_in("pytorch_lightning", LightningModule=lightning_module, LightningDataModule=type("Data", (), {"prepare_data": lambda _: None}))
    stand_in("pytorch_lightning.trainer", Trainer=Trainer)
    stand_in("tqdm")
    stand_in("tqdm.auto", tqdm=lambda items, *_, **__: items)
    np.int = int  # before NumPy 1.24
    # What it does once the texture is there.
    for name, function in (("textures.video_from_files", "main"), ("eval.eval_image_folders", "main"), ("scannet.render_mipmap_scannet", "main"),
                           ("matterport.render_mipmap_matterport", "main")):
        stand_in(f"scripts.{name}", **{function: None})
    sys.path.insert(0, str(options.checkout.resolve()))
    # As scripts/train/optimize_texture_scannet_with_angle_and_depth.sh has them.
    sys.argv = ["optimize", "--root_path", str(folder / "out/dataset"), "--texture_size", f"{SIZE_PX},{SIZE_PX}", "--min_images", "1",
                "--max_images", "1000", "--scene", "scene0000_00", "--hierarchical", "--hierarchical_layers", str(LAYERS), "--loss_weight", "content=7e1",
                "--loss_weight", "style=1e-4", "--style_weights=1000,1000,10,10,1000", "--loss_weight", "tex_reg=5e3", "--vgg_gatys_model_path",
                str(folder / "vgg.pth"), "--train_split", "0.99", "--val_split", "0.01", "--num_workers", "0", "--style_image_path",
                str(options.picture.resolve()), "--style_pyramid_mode", "multi", "--gram_mode", "current", "--angle_threshold", "30", "--pyramid_levels", "4",
                "--min_pyramid_depth", str(options.theta_d_m), "--min_pyramid_height", "256"]

    # Their losses add to a leaf in place, which only a copy on another device allows.
    zeros = torch.zeros
    torch.zeros = lambda *size, requires_grad=False, **more: zeros(*size, requires_grad=requires_grad, **more).clone()
    with contextlib.redirect_stdout(None), contextlib.suppress(StopIteration):
        runpy.run_module("model.optimize", run_name="__main__")
    torch.zeros = zeros
    return result["gradients"], result["loss"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("--checkout", "--scan", "--picture"):
        parser.add_argument(name, type=pathlib.Path, required=True)
    parser.add_argument("--fresco", type=pathlib.Path, default=ROOT / "build/bin/fresco")
    parser.add_argument("--theta_d_m", type=float, default=0.12)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        random_weights(folder / "vgg.pth")
        (folder / "step.yaml").write_text(PIPELINE.format(
            base=ROOT / "pipelines/presets/stylemesh-released-scannet.yaml", scan=options.scan.resolve(), picture=options.picture.resolve(),
            folder=folder, frames=FRAMES, size=SIZE_PX, theta_d_m=options.theta_d_m))
        subprocess.run([options.fresco, "run", folder / "step.yaml", "--until", "dataset", "--store", folder / "store", "--out", folder / "out", "--quiet"], check=True)
        layers, our_gradients, our_loss = our_step(options, folder)
        their_gradients, their_loss = their_step(layers, options, folder)
    print(f"style and content: {their_loss:.8g} theirs, {our_loss:.8g} ours, {our_loss / their_loss - 1:+.1e}")
    for i, (theirs, ours) in enumerate(zip(their_gradients, our_gradients)):
        cosine = (theirs * ours).sum() / np.linalg.norm(theirs) / np.linalg.norm(ours)
        print(f"layer {i}: cosine {cosine:.6f}, apart {np.linalg.norm(theirs - ours) / np.linalg.norm(theirs):.2e} in the L2 norm, "
              f"texels touched {(theirs != 0).any(0).sum()} / {(ours != 0).any(0).sum()}")


if __name__ == "__main__":
    main()
