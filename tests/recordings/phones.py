"""phones.py write: the generated room as the apps of phones would have recorded it, in the layouts of Record3D, Stray Scanner and
ARKitScenes. phones.py check: what Fresco reads of them is what was written."""
import json
import pathlib
import struct
import sys
import zipfile

import cv2
import fresco
import numpy as np

OPENGL = np.diag([1.0, -1, -1, 1])


def recorded():
    """K, world_from_camera (4 x 4), color (H x W x 3, BGR) and depth (mm) of each frame; all of the depth camera, which is color's, too."""
    made = fresco.open_results("made")
    for frame in made.read("scan", "frames"):
        color, depth = (cv2.imread(str(path), cv2.IMREAD_UNCHANGED) for path in
                        (made.path("scan", "frames") / frame[kind]["ref"].removeprefix("own:") for kind in ("color_picture", "depth_picture")))
        pose = np.array(frame["depth_camera"]["world_from_camera"])
        yield np.array(frame["depth_camera"]["K"]), pose, color, depth


def axis_times_angle(rotation):
    return cv2.Rodrigues(rotation)[0].ravel()


def quaternion(rotation):
    """x y z w."""
    turn = axis_times_angle(rotation)
    angle = np.linalg.norm(turn)
    return [*(turn / max(angle, 1e-12) * np.sin(angle / 2)), np.cos(angle / 2)]


def lzfse(values):
    """One stored block."""
    data = values.tobytes()
    return b"bvx-" + struct.pack("<I", len(data)) + data + b"bvx$"


def write_record3d(frames):
    folder = pathlib.Path("record3d")
    (folder / "rgbd").mkdir(parents=True)

    def seven(pose):
        return [*quaternion(pose[:3, :3]), *pose[:3, 3]]

    first = frames[0][1] @ OPENGL
    poses = []
    for i, (k, pose, color, depth) in enumerate(frames):
        cv2.imwrite(f"record3d/rgbd/{i}.jpg", color)
        (folder / f"rgbd/{i}.depth").write_bytes(lzfse((depth * 0.001).astype(np.float32)))
        (folder / f"rgbd/{i}.conf").write_bytes(lzfse(np.full(depth.shape, 2, np.uint8)))
        poses.append(seven(np.linalg.inv(first) @ pose @ OPENGL))
    (height, width), k = frames[0][3].shape, frames[0][0]
    (folder / "metadata").write_text(json.dumps({"w": width, "h": height, "dw": width, "dh": height, "K": k.T.ravel().tolist(), "fps": 30,
                                                 "poses": poses, "initPose": seven(first)}))
    with zipfile.ZipFile("room.r3d", "w") as archive:
        for file in sorted(folder.rglob("*")):
            archive.write(file, file.relative_to(folder))


def write_stray_scanner(frames):
    folder = pathlib.Path("stray_scanner")
    for name in ("depth", "confidence"):
        (folder / name).mkdir(parents=True)
    height, width = frames[0][3].shape
    video = cv2.VideoWriter("stray_scanner/rgb.mp4", cv2.VideoWriter_fourcc(*"mp4v"), 30, (width, height))
    odometry = "timestamp, frame, x, y, z, qx, qy, qz, qw\n"
    for i, (k, pose, color, depth) in enumerate(frames):
        video.write(color)
        cv2.imwrite(f"stray_scanner/depth/{i:06}.png", depth)
        cv2.imwrite(f"stray_scanner/confidence/{i:06}.png", np.full(depth.shape, 2, np.uint8))
        odometry += f"{100 + i / 60}, {i:06}, " + ", ".join(map(str, [*pose[:3, 3], *quaternion(pose[:3, :3])])) + "\n"
    video.release()
    (folder / "odometry.csv").write_text(odometry)
    np.savetxt(folder / "camera_matrix.csv", frames[0][0], delimiter=", ")


def write_arkitscenes(frames):
    folder = pathlib.Path("arkitscenes")
    for name in ("lowres_wide", "lowres_depth", "confidence", "lowres_wide_intrinsics"):
        (folder / name).mkdir(parents=True)
    trajectory = ""
    for i, (k, pose, color, depth) in enumerate(frames):
        time = f"{300 + i / 10:.3f}"
        for name, picture in (("lowres_wide", color), ("lowres_depth", depth), ("confidence", np.full(depth.shape, 2, np.uint8))):
            cv2.imwrite(f"arkitscenes/{name}/4_{time}.png", picture)
        (folder / f"lowres_wide_intrinsics/4_{time}.pincam").write_text(
            " ".join(map(str, [*depth.shape[::-1], k[0, 0], k[1, 1], k[0, 2], k[1, 2]])))
        camera_from_world = np.linalg.inv(pose)
        trajectory += f"{time} " + " ".join(map(str, [*axis_times_angle(camera_from_world[:3, :3]), *camera_from_world[:3, 3]])) + "\n"
    (folder / "lowres_wide.traj").write_text(trajectory)


def check():
    frames, read = list(recorded()), fresco.open_results("phones")
    for layout in ("record3d", "r3d", "stray_scanner", "arkitscenes"):
        found = read.read(layout, "frames")
        assert len(found) == len(frames), (layout, len(found))
        for frame, (k, pose, color, depth) in zip(found, frames):
            for kind in ("color_camera", "depth_camera"):
                assert np.abs(np.array(frame[kind]["K"]) - k).max() < 1e-6, (layout, frame[kind])
                assert np.abs(frame[kind]["world_from_camera"] - pose).max() < 1e-6, (layout, frame["name"])
            pictures = []
            for kind in ("color_picture", "depth_picture"):
                place, name = frame[kind]["ref"].split(":", 1)
                pictures.append(cv2.imread(str(read.path(layout, "frames") / name if place == "own" else name), cv2.IMREAD_UNCHANGED))
            assert np.abs(pictures[0].astype(float) - color).mean() < (8 if layout == "stray_scanner" else 3), (layout, frame["name"])
            assert (pictures[1] == depth).all(), (layout, frame["name"])


if sys.argv[1] == "write":
    written = list(recorded())
    write_record3d(written)
    write_stray_scanner(written)
    write_arkitscenes(written)
else:
    check()
