"""lenses.py write: recordings of one picture per camera model, as COLMAP and nerfstudio list them. lenses.py check: the frames that
Fresco made of them are what OpenCV makes of the pictures for the same pinhole cameras."""
import json
import pathlib
import sys

import cv2
import fresco
import numpy as np

SIZE = WIDTH, HEIGHT = 320, 240
FX, FY, CX, CY = 210.0, 215.0, 163.5, 117.25
# COLMAP's parameters behind the focal lengths and the principal point, and OpenCV's coefficients for the same lens.
MODELS = {
    "SIMPLE_RADIAL": ([-0.11], [-0.11, 0, 0, 0]),
    "RADIAL": ([-0.15, 0.04], [-0.15, 0.04, 0, 0]),
    "OPENCV": ([-0.2, 0.06, 0.004, -0.003], [-0.2, 0.06, 0.004, -0.003]),
    "FULL_OPENCV": ([0.3, -0.1, 0.002, -0.001, 0.05, 0.5, -0.05, 0.02], [0.3, -0.1, 0.002, -0.001, 0.05, 0.5, -0.05, 0.02]),
    "SIMPLE_FISHEYE": ([], [0, 0, 0, 0]),
    "FISHEYE": ([], [0, 0, 0, 0]),
    "SIMPLE_RADIAL_FISHEYE": ([0.05], [0.05, 0, 0, 0]),
    "RADIAL_FISHEYE": ([0.05, -0.01], [0.05, -0.01, 0, 0]),
    "OPENCV_FISHEYE": ([0.04, -0.01, 0.004, -0.001], [0.04, -0.01, 0.004, -0.001]),
}
# As those, but so wide that a part of it must be left out: 160° across.
WIDE = "OPENCV_FISHEYE of 160°", 115.0
KEYS = ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"]


def cameras():
    """Name, model, fx, fy and OpenCV's coefficients."""
    for model, (_, coefficients) in MODELS.items():
        yield model, model, FX, FX if model.startswith("SIMPLE") or "RADIAL" in model else FY, coefficients
    yield WIDE[0], "OPENCV_FISHEYE", WIDE[1], WIDE[1], MODELS["OPENCV_FISHEYE"][1]


def write():
    colmap, nerf = pathlib.Path("colmap"), pathlib.Path("nerf")
    for folder in (colmap / "images", colmap / "depth", nerf):
        folder.mkdir(parents=True)
    x, y = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    waves = 128 + 55 * np.sin(2 * np.pi * x / 17) + 55 * np.sin(2 * np.pi * y / 13)
    model_cameras, model_images, frames = "", "", []
    for i, (name, model, fx, fy, coefficients) in enumerate(cameras()):
        cv2.imwrite(f"colmap/images/{i}.png", np.repeat(waves[..., None], 3, 2).astype(np.uint8))
        cv2.imwrite(f"colmap/depth/{i}.png", (1000 + 3 * x + 5 * y).astype(np.uint16))
        focal = [fx] if model.startswith("SIMPLE") or "RADIAL" in model else [fx, fy]
        parameters = [*focal, CX, CY, *MODELS[model][0]]
        model_cameras += f"{i} {model} {WIDTH} {HEIGHT} {' '.join(map(str, parameters))}\n"
        model_images += f"{i} 1 0 0 0 {i} 0 0 {i} {i}.png\n\n"
        is_fisheye = "FISHEYE" in model
        keys = ["k1", "k2", "k3", "k4"] if is_fisheye else KEYS
        frame = {"file_path": f"../colmap/images/{i}.png", "depth_file_path": f"../colmap/depth/{i}.png", "w": WIDTH, "h": HEIGHT,
                 "camera_model": "OPENCV_FISHEYE" if is_fisheye else model, "fl_x": fx, "fl_y": fy, "cx": CX, "cy": CY,
                 "transform_matrix": np.diag([1.0, -1, -1, 1]).tolist()}
        frames.append(frame | dict(zip(keys, coefficients)))
    (colmap / "cameras.txt").write_text(model_cameras)
    (colmap / "images.txt").write_text(model_images)
    (nerf / "transforms.json").write_text(json.dumps({"frames": frames}))


def check():
    made = fresco.open_results("lenses")
    for stage in ("colmap", "nerf"):
        frames = made.read(stage, "frames")
        assert len(frames) == len(MODELS) + 1, (stage, len(frames))
        for i, (frame, (name, model, fx, fy, coefficients)) in enumerate(zip(frames, cameras())):
            pinhole = frame["color_camera"]
            new, old = np.array(pinhole["K"], float), np.array([[fx, 0, CX], [0, fy, CY], [0, 0, 1]])
            # OpenCV has the center of the first pixel at (0, 0).
            new[:2, 2] -= 0.5
            old[:2, 2] -= 0.5
            undistort = cv2.fisheye.initUndistortRectifyMap if "FISHEYE" in model else cv2.initUndistortRectifyMap
            column, row = undistort(old, np.array(coefficients, float), np.eye(3), new, SIZE, cv2.CV_32FC1)
            folder = made.path(stage, "frames")
            color, depth = (cv2.imread(str(folder / frame[kind]["ref"].removeprefix("own:")), cv2.IMREAD_UNCHANGED)
                            for kind in ("color_picture", "depth_picture"))
            expected = cv2.remap(cv2.imread(f"colmap/images/{i}.png"), column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            expected_depth = cv2.remap(cv2.imread(f"colmap/depth/{i}.png", cv2.IMREAD_UNCHANGED), column, row, cv2.INTER_NEAREST,
                                       borderMode=cv2.BORDER_REPLICATE)
            # Half a pixel would be 10 steps of color.
            off = np.abs(color.astype(float) - expected).mean()
            assert off < 2, (stage, name, off)
            # Between two pixels, the last bit decides.
            other = (np.abs(depth.astype(int) - expected_depth) > 0).mean()
            assert other < 0.01, (stage, name, other)
            # All pixels have a source, and with a longer view some would not; but fisheyes end at 100°.
            half = 0.5 + 1e-3
            assert -half <= column.min() and column.max() <= WIDTH - 1 + half and -half <= row.min() and row.max() <= HEIGHT - 1 + half, name
            across = 2 * np.degrees(np.arctan(WIDTH / 2 / new[0, 0]))
            assert (abs(across - 100) < 0.01) == (name == WIDE[0]) and across < 100.01, (name, across)


{"write": write, "check": check}[sys.argv[1]]()
