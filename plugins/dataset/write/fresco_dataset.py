"""Reads a dataset that fresco's dataset.write made. NumPy is all it needs; PyTorch only for `tensors=True`.

    from fresco_dataset import Dataset
    room = Dataset("room")                      # the folder in which dataset.json is
    view = room[3]                              # a dict, see Dataset.__getitem__
    view = Dataset("room", height_px=256)[3]    # at another of room.heights_px
    loader = torch.utils.data.DataLoader(Dataset("room", tensors=True), batch_size=4, shuffle=True)

Conventions (dataset.json says them too): meters; OpenCV camera axes (x right, y down, z forward); poses are world_from_camera; the
first pixel's center is at (0.5, 0.5); uv origin at the lower left; rows from the top; depth along the optical axis; sRGB.
"""
import json
import pathlib

import numpy as np


class Dataset:
    """Its views in recorded order: as long as `len` says, by number, iterable, and what torch.utils.data.DataLoader takes.

    height_px   which height the views have, the largest if left out
    tensors     torch tensors in place of arrays: pictures as float32 C x H x W in [0,1], all else as it is
    """

    def __init__(self, folder, height_px=None, tensors=False):
        self.folder = pathlib.Path(folder)
        manifest = self.folder / "dataset.json"
        if not manifest.is_file():
            raise FileNotFoundError(f"{manifest}: is missing: not a dataset, or an incomplete copy")
        self.manifest = json.loads(manifest.read_text(encoding="utf-8"))
        if self.manifest.get("format") != "fresco.dataset" or self.manifest.get("version") != 1:
            raise ValueError(f"{manifest}: format fresco.dataset, version 1, was expected")
        self.heights_px = self.manifest["heights_px"]
        self.height_px = self.heights_px[-1] if height_px is None else height_px
        if self.height_px not in self.heights_px:
            raise ValueError(f"{manifest}: no height of {height_px} px, there are {self.heights_px}")
        self.tensors = tensors
        self.has_sensor_depth = all(view["depth_unit_m"] is not None for view in self.manifest["views"])

    def __len__(self):
        return len(self.manifest["views"])

    def __getitem__(self, number):
        """A dict of one view, H x W its pixels:

        uv (float32 H x W x 2, in [0,1]), depth (float32 H x W), cosine (float32 H x W, of the angle between normal and view), valid
        (bool H x W: the mesh is seen; elsewhere the maps are 0), color (uint8 H x W x 3), intrinsics (float64 3 x 3, of this height),
        world_from_camera (float64 4 x 4), number, name.

        If every view has a depth picture, also what the depth camera measured: sensor_depth (float32 h x w, meters, 0: nothing),
        sensor_intrinsics (float64 3 x 3), world_from_sensor (float64 4 x 4).
        """
        if not -len(self) <= number < len(self):
            raise IndexError(f"view {number} of {len(self)}")
        number %= len(self)
        entry = self.manifest["views"][number]
        uv = self.array(number, "uv")
        if uv.dtype == np.uint16:
            uv = uv.astype(np.float32) / np.float32(65535)
        view = {
            "uv": uv,
            "depth": self.array(number, "depth"),
            "cosine": self.array(number, "cosine"),
            "valid": self.array(number, "valid").astype(bool),
            "color": self.array(number, "color"),
            "intrinsics": self.intrinsics(number),
            "world_from_camera": _pose(entry["color_camera"]),
            "number": number,
            "name": f"{entry['sequence']}/{entry['frame']}",
        }
        if self.has_sensor_depth:
            camera = entry["depth_camera"]
            view["sensor_depth"] = self.sensor_depth(number)
            view["sensor_intrinsics"] = _matrix(camera, camera["width"], camera["height"])
            view["world_from_sensor"] = _pose(camera)
        if self.tensors:
            import torch

            for key, value in view.items():
                if isinstance(value, np.ndarray):
                    view[key] = torch.from_numpy(np.ascontiguousarray(value))
            view["color"] = view["color"].permute(2, 0, 1).float() / 255
        return view

    def array(self, number, quantity):
        """uv, depth, cosine, valid or color as it is stored."""
        file = self.folder / f"views/{number:06d}/{quantity}_{self.height_px}.npy"
        array = np.load(file, allow_pickle=False)
        entry = self.manifest["views"][number]["color_camera"]
        width = max(1, int(np.floor(self.height_px * entry["width"] / entry["height"] + 0.5)))
        if array.shape[:2] != (self.height_px, width):
            raise ValueError(f"{file}: {array.shape[0]} x {array.shape[1]} pixels; {self.height_px} x {width} were expected")
        return array

    def intrinsics(self, number):
        """3 x 3, for the pixels of this height."""
        camera = self.manifest["views"][number]["color_camera"]
        width = max(1, int(np.floor(self.height_px * camera["width"] / camera["height"] + 0.5)))
        return _matrix(camera, width, self.height_px)

    def picture(self, number):
        """The camera picture at full size, uint8 H x W x 3."""
        return np.load(self.folder / f"views/{number:06d}/color.npy", allow_pickle=False)

    def sensor_depth(self, number):
        """What the depth camera measured, float32 meters, 0 where nothing was measured; None without a depth picture. Another camera: `depth_camera`."""
        unit = self.manifest["views"][number]["depth_unit_m"]
        if unit is None:
            return None
        steps = np.load(self.folder / f"views/{number:06d}/sensor_depth.npy", allow_pickle=False)
        return np.where(steps == 65535, 0, steps).astype(np.float32) * np.float32(unit)

    def style(self):
        """The style picture, uint8 H x W (x C), or None."""
        return np.load(self.folder / "style.npy", allow_pickle=False) if self.manifest["has_style"] else None

    def mesh(self):
        """positions (float32 V x 3, meters), triangles (int32 F x 3) and texcoords (float32 F x 3 x 2: of each face's corners)."""
        bytes_ = (self.folder / "mesh.ply").read_bytes()
        end = bytes_.index(b"end_header\n") + len(b"end_header\n")
        kinds = {"float": "<f4", "uchar": "u1", "int": "<i4"}
        rows = {}
        for line in bytes_[:end].decode("ascii").splitlines():
            words = line.split()
            if words[0] == "element":
                name, count, fields = words[1], int(words[2]), []
                rows[name] = (count, fields)
            elif words[:2] == ["property", "list"]:
                # Only triangles: three indices, six texcoords.
                length = 3 if words[4] == "vertex_indices" else 6
                fields += [(f"{words[4]}_count", kinds[words[2]]), (words[4], kinds[words[3]], (length,))]
            elif words[0] == "property":
                fields.append((words[2], kinds[words[1]]))
        arrays = {}
        for name, (count, fields) in rows.items():
            arrays[name] = np.frombuffer(bytes_, np.dtype(fields), count, end)
            end += arrays[name].nbytes
        vertex, face = arrays["vertex"], arrays["face"]
        if end != len(bytes_) or (face["vertex_indices_count"] != 3).any() or (face["texcoord_count"] != 6).any():
            raise ValueError(f"{self.folder / 'mesh.ply'}: is not the mesh that dataset.write makes")
        positions = np.stack([vertex["x"], vertex["y"], vertex["z"]], 1)
        return positions, face["vertex_indices"].copy(), face["texcoord"].reshape(-1, 3, 2).copy()

    def check(self, sizes_only=False):
        """Raises ValueError naming the first listed file that is missing or has another size or, unless `sizes_only`, other
        contents. Contents are compared by the package xxhash: raises ImportError where it is not installed."""
        if not sizes_only:
            try:
                import xxhash
            except ImportError as error:
                raise ImportError("check() compares contents by the package xxhash, which is not installed: pip install xxhash "
                                  "(Debian: python3-xxhash), or check(sizes_only=True), which does not notice other contents") from error
        for listed in self.manifest["files"]:
            file = self.folder / listed["name"]
            if not file.is_file() or file.stat().st_size != listed["bytes"]:
                raise ValueError(f"{file}: is missing or has not {listed['bytes']} bytes: copy the dataset again")
            if not sizes_only and xxhash.xxh3_128_hexdigest(file.read_bytes()) != listed["hash"]:
                raise ValueError(f"{file}: has other contents than dataset.json lists: copy the dataset again")


def _matrix(camera, width, height):
    """The intrinsics of a camera of the manifest, for pictures of another size."""
    x, y = width / camera["width"], height / camera["height"]
    return np.array([[camera["fx"] * x, 0, camera["cx"] * x], [0, camera["fy"] * y, camera["cy"] * y], [0, 0, 1]])


def _pose(camera):
    return np.vstack([np.reshape(camera["world_from_camera"], (3, 4)), [0, 0, 0, 1]])


def points(view):
    """H x W x 3: the world point that each pixel of a view shows; meaningless where it is not valid. Of tensors, also of a batch
    (B x H x W x 3), a tensor on their device."""
    depth, intrinsics, pose = view["depth"], view["intrinsics"], view["world_from_camera"]
    height, width = depth.shape[-2:]
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    pixels = np.stack([x, y, np.ones_like(x)], -1).reshape(-1, 3)
    if isinstance(depth, np.ndarray):
        inverse = np.linalg.inv(intrinsics)
    else:
        import torch

        pixels, inverse = torch.from_numpy(pixels).to(intrinsics), torch.linalg.inv(intrinsics)
    rays = pixels @ inverse.swapaxes(-1, -2)
    seen = rays * depth.reshape(*depth.shape[:-2], -1, 1)
    return (seen @ pose[..., :3, :3].swapaxes(-1, -2) + pose[..., None, :3, 3]).reshape(*depth.shape, 3)


def sampling_grid(uv):
    """`uv` (… x 2, arrays or tensors) as torch.nn.functional.grid_sample(texture, grid, align_corners=False) takes it for a texture
    whose row 0 is at the top (v = 1), as fresco's pictures are: x and y from -1 to 1, y downwards."""
    grid = uv * 2 - 1
    grid[..., 1] *= -1
    return grid
