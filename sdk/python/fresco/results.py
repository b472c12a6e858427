"""Reads what a run left: run.json, and the artifacts in the store, whose files sdk/docs/artifacts.md lists."""
from __future__ import annotations

import json
import os
import pathlib
from typing import Any, Iterator, Mapping, Union

import numpy as np
import numpy.typing as npt

from .ply import read_mesh
from .rasters import read_raster
from .uv_maps import read_uv_map

Array = npt.NDArray[Any]


def open_results(out: Union[str, "os.PathLike[str]"] = "out") -> Result:
    """The results of an earlier run, from its folder `--out`. Raises FileNotFoundError where no run wrote them."""
    folder = pathlib.Path(out)
    found = [file for file in (folder / "run.json", folder / "sweep.json") if file.is_file()]
    if not found:
        raise FileNotFoundError(f"{folder}: neither run.json nor sweep.json is there: no results of a run")
    return Result(folder, _json(max(found, key=lambda file: file.stat().st_mtime_ns)))


class Result:
    """What a run left. `data` is run.json, or, of a matrix, sweep.json: pipelines/results.md lists the entries."""

    def __init__(self, folder: pathlib.Path, data: dict[str, Any]) -> None:
        self.folder, self.data = folder, data
        self.stages: dict[str, dict[str, Any]] = {stage["name"]: stage for stage in data["stages"]}

    @property
    def combinations(self) -> dict[str, Result]:
        """Of a matrix, the finished combinations by name, such as "kitchen,waves"; else empty."""
        names = [entry["name"] for entry in self.data.get("combinations", []) if entry["state"] == "done"]
        return {name: open_results(self.folder / name) for name in names}

    @property
    def files(self) -> list[pathlib.Path]:
        """The exported files."""
        return [self.folder / file["name"] for file in self.data.get("files", [])]

    def figures(self, stage: str) -> dict[str, Any]:
        """What the stage reported: {name: number, text, list or dict}."""
        return dict(self._stage(stage)["figures"])

    def path(self, stage: str, output: str = "") -> pathlib.Path:
        """The folder of an artifact in the store; `output` may be left out if the stage has one."""
        result, output = self._stage(stage), self._output(stage, output)
        folder = pathlib.Path(self.data["store"]) / "objects" / (result["object"] or "-") / output
        if not folder.is_dir():
            raise FileNotFoundError(f"{stage}.{output}: its result is not in {self.data['store']}: run the pipeline again")
        return folder

    def read(self, stage: str, output: str = "") -> Any:
        """An artifact as NumPy arrays, by its type. In a combination, the stage's name in the pipeline file suffices.

        mesh           a dict as fresco.ply.read_mesh returns it
        image          uint8, H x W x 1, 3 or 4
        texture        a list of float32 arrays, size x size x 3, finest first
        textured_mesh  a mesh with "image": uint8, size x size x 3
        uv_maps        a mapping {(view, height): fresco.uv_maps.read_uv_map's dict}, each read when it is asked for
        frames         a list of dicts: frames.json's, with color_camera and depth_camera each having K (3 x 3) and
                       world_from_camera (4 x 4), float64
        regions        {name: bool array, one entry per face}
        relief         normals in the world: float32, size x size x 3; (-1, -1, -1) away from charts
        source_map     the style picture's place of each texel, as texture.h describes it: uint16, size x size x 4;
                       shifts.packed in path() holds the shifts of their colors
                       (fresco.rasters.read_raster reads it)
        table          {column: array}

        Raises TypeError for other types: their files are in path()."""
        folder = self.path(stage, output)
        kind = next(o["artifact"] for o in self._stage(stage)["outputs"] if o["name"] == folder.name)
        if kind not in READERS:
            raise TypeError(f"{stage}.{folder.name}: an artifact of type {kind} is not read here; its files are in {folder}")
        return READERS[kind](folder, pathlib.Path(self.data["store"]))

    def _stage(self, name: str) -> dict[str, Any]:
        """By its name, or by the one that it has in the pipeline file: in a combination, "mesh" is "mesh@kitchen"."""
        found = [self.stages[name]] if name in self.stages else [stage for stage in self.stages.values() if stage["own_name"] == name]
        if len(found) > 1:
            raise KeyError(f"the stage '{name}' ran for several combinations: {', '.join(stage['name'] for stage in found)}; name one of these, "
                           f"or use .combinations[…], which has: {', '.join(self.combinations)}")
        if not found:
            raise KeyError(f"no stage '{name}'; there are: {', '.join(self.stages)}")
        return found[0]

    def _output(self, stage: str, output: str) -> str:
        names = [entry["name"] for entry in self._stage(stage)["outputs"]]
        if output in names:
            return output
        if output or len(names) != 1:
            raise KeyError(f"the stage '{stage}' has the outputs {', '.join(names)}" + (f", not '{output}'" if output else ": choose one"))
        return str(names[0])


class UvMaps(Mapping[tuple[int, int], dict[str, Array]]):
    """The uv maps of a folder, by view and height."""

    def __init__(self, folder: pathlib.Path) -> None:
        self.folder = folder
        self.data = _json(folder / "uvmaps.json")

    def __getitem__(self, key: tuple[int, int]) -> dict[str, Array]:
        view, height = key
        if not 0 <= view < len(self.data["views"]) or height not in self.data["heights_px"]:
            raise KeyError(key)
        return read_uv_map(self.folder / f"{view:06}_{height}.uvmap")

    def __iter__(self) -> Iterator[tuple[int, int]]:
        return ((view, height) for view in range(len(self.data["views"])) for height in self.data["heights_px"])

    def __len__(self) -> int:
        return len(self.data["views"]) * len(self.data["heights_px"])


def _json(path: pathlib.Path) -> Any:
    return json.loads(path.read_text("utf-8"))


def _texture(folder: pathlib.Path, _: pathlib.Path) -> list[Array]:
    return [read_raster(folder / f"layer_{i}.packed") for i in range(_json(folder / "texture.json")["layers"])]


def _textured_mesh(folder: pathlib.Path, _: pathlib.Path) -> dict[str, Any]:
    return {**read_mesh(folder / "mesh.ply"), "image": read_raster(folder / "image.packed")}


def _frames(folder: pathlib.Path, _: pathlib.Path) -> list[dict[str, Any]]:
    frames: list[dict[str, Any]] = _json(folder / "frames.json")["frames"]
    for frame in frames:
        for camera in (frame[name] for name in ("color_camera", "depth_camera") if frame.get(name)):
            camera["K"] = np.array([[camera["fx"], 0, camera["cx"]], [0, camera["fy"], camera["cy"]], [0, 0, 1]])
            camera["world_from_camera"] = np.vstack([np.reshape(camera["world_from_camera"], (3, 4)), [0, 0, 0, 1]])
    return frames


def _regions(folder: pathlib.Path, _: pathlib.Path) -> dict[str, Array]:
    labels = np.load(folder / "labels.npy")
    return {name: labels == i for i, name in enumerate(_json(folder / "regions.json")["names"])}


def _table(folder: pathlib.Path, _: pathlib.Path) -> dict[str, Array]:
    table = _json(folder / "table.json")
    return {name: np.array([row[i] for row in table["rows"]]) for i, name in enumerate(table["columns"])}


READERS = {
    "mesh": lambda folder, _: read_mesh(folder / "mesh.ply"),
    "image": lambda folder, _: read_raster(folder / "image.packed"),
    "texture": _texture,
    "textured_mesh": _textured_mesh,
    "uv_maps": lambda folder, _: UvMaps(folder),
    "frames": _frames,
    "regions": _regions,
    "relief": lambda folder, _: (read_raster(folder / "normals.packed") / np.float32(32767.5) - 1).astype(np.float32),
    "source_map": lambda folder, _: read_raster(folder / "places.packed"),
    "table": _table,
}
