"""test_python.py FRESCO: what the package promises."""
import os
import pathlib
import signal
import subprocess
import sys
import unittest
import unittest.mock

import numpy as np

import fresco
import fresco.ply

STAGES = {
    "scan": {"type": "scan.synthetic_room", "frames_count": 4, "color_width_px": 160, "color_height_px": 120},
    "mesh": {"type": "mesh.decimate", "input": "scan", "max_faces": 20000},
    "atlas": {"type": "atlas.project", "input": "mesh", "size_px": 256},
    "uvmaps": {"type": "uvmaps.raster", "input": {"mesh": "atlas", "frames": "scan"}, "heights_px": [60, 120]},
    "photo": {"type": "texture.from_frames", "input": {"uvmaps": "uvmaps", "frames": "scan"}},
    "bake": {"type": "texture.bake", "input": {"texture": "photo", "mesh": "atlas"}},
    "file": {"type": "export.mesh", "input": "bake", "path": "room.npy"},
}
# Braces in 'run' are doubled.
TABLE = """sleep ${seconds}; echo '{{"columns": ["a", "b"], "rows": [[1, "x"], [2.5, "y"]]}}' >$1"""
SLOW = {"slow": {"type": "command", "run": ["sh", "-c", TABLE, "sh", "{t}"], "outputs": {"t": "table"}}}


class Results(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.lines = []
        cls.result = fresco.run({"stages": STAGES}, cores=2, on_progress=lambda progress: cls.lines.append(str(progress)))

    def test_progress_names_stages(self):
        self.assertTrue(any("running: scan" in line and "/4 frames" in line for line in self.lines), self.lines)
        self.assertIn(f"{len(STAGES)} stages ended; running: none", self.lines[-1])

    def test_meshes(self):
        mesh = self.result.read("atlas")
        self.assertEqual(len(mesh["triangles"]), self.result.figures("mesh")["faces_after"])
        self.assertEqual(mesh["charts"].max() + 1, self.result.figures("atlas")["charts"])
        self.assertEqual(mesh["texture_px"], 256)
        extent = np.ptp(mesh["positions"], axis=0)
        self.assertTrue((extent > 2).all() and (extent < 6).all(), extent)

    def test_uv_maps_show_the_surface_that_cameras_see(self):
        maps, frames, mesh = self.result.read("uvmaps"), self.result.read("scan", "frames"), self.result.read("atlas")
        self.assertEqual(list(maps), [(view, height) for view in range(4) for height in (60, 120)])
        one, camera = maps[2, 120], frames[2]["color_camera"]
        rows, columns = np.nonzero(one["valid"])
        rays = np.linalg.inv(camera["K"]) @ np.stack([columns + 0.5, rows + 0.5, np.ones(len(rows))])
        points = camera["world_from_camera"] @ np.vstack([rays * one["depth"][rows, columns], np.ones(len(rows))])
        low, high = mesh["positions"].min(0) - 0.01, mesh["positions"].max(0) + 0.01
        self.assertGreater(len(rows), 10000)
        self.assertTrue(((points[:3].T >= low) & (points[:3].T <= high)).all())
        with self.assertRaises(KeyError):
            maps[4, 120]

    def test_pictures_are_those_that_are_exported(self):
        self.assertEqual(self.result.files, [pathlib.Path("out/room.npy")])
        baked = self.result.read("bake")
        np.testing.assert_array_equal(baked["image"], np.load("out/room.npy"))
        np.testing.assert_array_equal(baked["texcoords"], self.result.read("atlas")["texcoords"])
        layers = self.result.read("photo")
        self.assertEqual([layer.shape for layer in layers], [(256, 256, 3)])

    def test_regions_part_the_mesh(self):
        regions = self.result.read("scan", "regions")
        self.assertEqual(set(regions), {"floor", "ceiling", "walls", "furniture"})
        self.assertTrue((sum(part.astype(int) for part in regions.values()) == 1).all())
        self.assertEqual(len(regions["floor"]), len(self.result.read("scan", "mesh")["triangles"]))

    def test_an_earlier_run_is_opened(self):
        again = fresco.open_results()
        self.assertEqual(again.figures("scan"), self.result.figures("scan"))
        with self.assertRaisesRegex(FileNotFoundError, "run.json"):
            fresco.open_results("nothing")

    def test_unknown_names(self):
        for name, output, text in (("scam", "", "there are: scan"), ("scan", "", "frames, mesh, regions: choose one"), ("scan", "m", "not 'm'")):
            with self.assertRaisesRegex(KeyError, text):
                self.result.read(name, output)
        with self.assertRaisesRegex(TypeError, "type files"):
            self.result.read("file")


class Runs(unittest.TestCase):
    def refused(self, exit_code, text, call, *arguments, **more):
        with self.assertRaisesRegex(fresco.FrescoError, text) as raised:
            call(*arguments, **more)
        self.assertEqual(raised.exception.exit_code, exit_code)

    def test_what_is_wrong_with_a_pipeline(self):
        wrong = {"stages": {"scan": {"type": "scan.recordings"}}}
        self.refused(2, "^error: stage 'scan': unknown type 'scan.recordings' .did you mean", fresco.check, wrong)
        self.refused(3, "nothing.yaml", fresco.run, "nothing.yaml")
        fails = {"type": "command", "run": ["sh", "-c", "exit 7", "{t}"], "outputs": {"t": "table"}}
        self.refused(1, "(?s)fail.*exit code 7", fresco.run, {"stages": {"fail": fails}}, out="failed")
        fresco.check({"stages": STAGES}, {"mesh.max_faces": 5000})

    def test_a_command_that_is_not_there(self):
        with unittest.mock.patch.object(fresco, "program", "no_such_fresco"):
            for call in (fresco.run, fresco.check):
                self.refused(127, "'no_such_fresco' was not found: .*PATH.*fresco.program", call, {"stages": STAGES})

    def test_a_mesh_that_has_other_faces_than_triangles(self):
        mesh = {"positions": np.zeros((3, 3), np.float32), "triangles": np.array([[0, 1, 2]])}
        fresco.ply.write_mesh("triangle.ply", mesh)
        np.testing.assert_array_equal(fresco.ply.read_mesh("triangle.ply")["triangles"], mesh["triangles"])
        contents = bytearray(pathlib.Path("triangle.ply").read_bytes())
        contents[contents.index(b"end_header\n") + 11 + 36] = 4
        pathlib.Path("quad.ply").write_bytes(contents)
        with self.assertRaisesRegex(ValueError, "quad.ply: has faces that are no triangles"):
            fresco.ply.read_mesh("quad.ply")

    def test_a_silent_stage_is_seen_at_least_once_per_second(self):
        times = []
        result = fresco.run({"vars": {"seconds": 3}, "stages": SLOW}, out="slow", on_progress=lambda progress: times.append(dict(progress.running)))
        self.assertGreaterEqual(times.count({"slow": ""}), 4)
        table = result.read("slow")
        np.testing.assert_array_equal(table["a"], [1, 2.5])
        np.testing.assert_array_equal(table["b"], ["x", "y"])

    def test_an_interrupted_run_leaves_nothing_behind_and_resumes(self):
        seconds = 10_000_000 + os.getpid()  # No other process sleeps so long.
        pipeline = {"vars": {"seconds": seconds}, "stages": {**SLOW, "scan": STAGES["scan"]}}
        fresco.run({"stages": {"scan": STAGES["scan"]}}, out="scanned", store="store")

        def interrupt(progress):
            if "slow" in progress.running:
                signal.raise_signal(signal.SIGINT)

        with self.assertRaises(KeyboardInterrupt):
            fresco.run(pipeline, out="interrupted", store="store", on_progress=interrupt)
        self.assertNotIn(str(seconds), subprocess.run(["ps", "ax", "-o", "args"], capture_output=True, text=True, check=True).stdout)
        left = fresco.open_results("interrupted")
        self.assertEqual((left.data["exit_code"], left.data["outcome"]), (75, "interrupted"))
        result = fresco.run(pipeline, {"seconds": 0}, out="interrupted", store="store")
        self.assertEqual({name: stage["state"] for name, stage in result.stages.items()}, {"scan": "stored", "slow": "ran"})

    def test_an_error_of_the_callers_stops_the_run(self):
        def fail(progress):
            raise ZeroDivisionError

        with self.assertRaises(ZeroDivisionError):
            fresco.run({"vars": {"seconds": 5000}, "stages": SLOW}, out="stopped", store="store", on_progress=fail)

    def test_combinations_of_a_matrix(self):
        result = fresco.run({"vars": {"seed": 1}, "matrix": {"seed": [1, 2]}, "stages": {"scan": STAGES["scan"] | {"seed": "${seed}"}}}, out="matrix")
        self.assertEqual(list(result.combinations), ["seed=1", "seed=2"])
        first, second = (one.read("scan", "mesh")["positions"] for one in result.combinations.values())
        self.assertFalse(np.array_equal(first, second))
        np.testing.assert_array_equal(result.read("scan@seed=2", "mesh")["positions"], second)
        with self.assertRaisesRegex(KeyError, "several combinations: scan@seed=1, scan@seed=2.*combinations.*seed=1, seed=2"):
            result.read("scan", "mesh")
        self.assertEqual(result.combinations["seed=1"].path("scan", "mesh"), result.path("scan@seed=1", "mesh"))

    def test_a_result_that_is_gone(self):
        result = fresco.run({"stages": {"scan": STAGES["scan"]}}, out="gone", store="gone_store")
        subprocess.run(["rm", "-r", "gone_store/objects"], check=True)
        with self.assertRaisesRegex(FileNotFoundError, "run the pipeline again"):
            result.read("scan", "mesh")


fresco.program = sys.argv.pop(1)
unittest.main(verbosity=1)
