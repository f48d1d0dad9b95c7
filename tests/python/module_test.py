"""Tests of the Python module kerf: python3 -m unittest, with the build's python folder in PYTHONPATH (ctest -R python)."""

import gc
import math
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import kerf

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
UPRIGHT = ((1, 0, 0), -90)  # the spindle points along y


def small_block(voxel_mm=0.2):
    return kerf.Bone.block(size_mm=(12, 6, 6), layers=[(2, 24), (4, 32)], voxel_mm=voxel_mm)


def slot(bone, **more):
    """Returns a simulation that is about to cut a slot 2 mm deep, and the poses of the cut."""
    start = kerf.pose((-12, 0, 3), *UPRIGHT)
    tool = kerf.Disc(diameter_mm=10, thickness_mm=0.5)
    return kerf.Simulation(bone, start, tool=tool, **more), kerf.line(start, (0, 0, 3), 20)


class Bones(unittest.TestCase):
    def test_block_has_its_volume_distances_regions_and_moduli(self):
        bone = small_block()
        # Edges are rounded within a voxel: 12 edges, 96 mm long, each loses at most a triangle of half a voxel squared.
        self.assertAlmostEqual(bone.volume_mm3(), 12 * 6 * 6, delta=96 * 0.5 * 0.2**2)
        points = np.array([[0, 0, 0.3], [0, 0, -0.3], [0, 0, -1], [0, 0, -5]])
        np.testing.assert_allclose(bone.phi(points)[:2], [0.3, -0.3], atol=1e-6)  # single precision
        np.testing.assert_array_equal(bone.region(points)[1:], [24, 24, 32])
        table = bone.materials
        np.testing.assert_allclose(bone.modulus(points)[[2, 3]], [table[24].E_MPa, table[32].E_MPa], rtol=1e-6)
        np.testing.assert_allclose(bone.poisson_ratio(points)[[2, 3]], [table[24].nu, table[32].nu], rtol=1e-6)
        np.testing.assert_allclose(bone.bounds_mm(), [[-6, -3, -6], [6, 3, 0]], atol=0.02)
        self.assertAlmostEqual(sum(bone.region_volumes_mm3().values()), bone.volume_mm3(), places=6)

    def test_mesh_encloses_the_volume(self):
        bone = small_block()
        points, triangles = bone.mesh()
        self.assertEqual(points.dtype, np.float64)
        self.assertEqual(triangles.dtype, np.uint32)
        a, b, c = (points[triangles[:, i]] for i in range(3))
        volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6  # divergence theorem
        self.assertAlmostEqual(volume, bone.volume_mm3(), delta=96 * 0.5 * 0.2**2)

    def test_leaves_are_the_bones_own_memory(self):
        bone = small_block()
        first, leaves = bone.leaves()
        again = bone.leaves()[1]
        address = [leaf.__array_interface__["data"][0] for leaf in leaves]
        self.assertEqual(address, [leaf.__array_interface__["data"][0] for leaf in again])
        self.assertEqual(first.shape, (len(leaves), 3))
        with self.assertRaises(ValueError):
            leaves[0][0, 0, 0] = 1
        # A voxel's value is the distance at its centre.
        p = bone.voxel_mm * (first[3] + [1, 2, 3])
        self.assertAlmostEqual(float(leaves[3][1, 2, 3]), bone.phi(p[None])[0], places=6)
        # The arrays keep the bone alive.
        value = leaves[0].copy()
        del bone, again
        gc.collect()
        np.testing.assert_array_equal(leaves[0], value)

    def test_labels_make_a_bone(self):
        labels = np.zeros((20, 10, 10), dtype=np.uint8)
        labels[:10], labels[10:] = 1, 2
        bone = kerf.Bone.from_labels(labels, {1: 24, 2: 32}, voxel_mm=0.2, spacing_mm=(0.5, 0.5, 0.5), pose=(10, 0, 0))
        np.testing.assert_array_equal(bone.region(np.array([[11, 2, 2], [18, 2, 2]])), [24, 32])
        # 500 mm3, less the rounded edges: at most a lattice voxel's quarter along 76 mm of edges.
        self.assertAlmostEqual(bone.volume_mm3(), 10 * 5 * 5 * 1.0, delta=76 * 0.25 * 0.5**2)
        # The order of the array's memory does not matter.
        other = kerf.Bone.from_labels(np.asfortranarray(labels), {1: 24, 2: 32}, 0.2, (0.5, 0.5, 0.5), (10, 0, 0))
        self.assertEqual(other.hash(), bone.hash())

    def test_files_keep_every_bit(self):
        bone = small_block()
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "bone.vdb"
            bone.write(path)
            self.assertEqual(kerf.Bone.read(path).hash(), bone.hash())
            self.assertEqual(kerf.Bone.read(str(path)).materials.csv(), bone.materials.csv())

    def test_surface_is_imported_with_its_volume(self):
        points, triangles = small_block().mesh()
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "block.obj"
            path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in points) +
                            "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in triangles))
            bone, report = kerf.Bone.from_file(path, voxel_mm=0.2, mesh_units="mm")
            self.assertAlmostEqual(bone.volume_mm3(), 432, delta=2 * 96 * 0.5 * 0.2**2)
            self.assertFalse(report["mandible"])

    def test_materials_are_made_and_replaced(self):
        table = kerf.Materials([kerf.Region(24, "hard", "cortical", 15000, 0.3), kerf.Region(32, "soft", "cancellous", 500, 0.3)])
        bone = small_block().with_materials(table)
        self.assertEqual(bone.materials[24].E_MPa, 15000)
        self.assertEqual(kerf.Materials.parse(table.csv()).csv(), table.csv())
        self.assertEqual({r.E_MPa for r in table.uniform(9000, 0.3).regions.values()}, {9000})

    def test_pieces_add_up(self):
        bone = small_block()
        simulation = kerf.Simulation(bone, kerf.pose((0, 0, 20)), tool=kerf.Disc(diameter_mm=30, thickness_mm=0.5))
        simulation.set_down(kerf.pose((0, 0, 20), *(((0, 1, 0)), 90)))  # the disc lies in the y-z plane
        simulation.run(kerf.line(kerf.pose((0, 0, 20), (0, 1, 0), 90), (0, 0, 0), 20))
        cut = simulation.bone()
        pieces = cut.pieces()
        self.assertEqual(len(pieces), 2)
        self.assertAlmostEqual(sum(p.volume_mm3() for p in pieces), cut.volume_mm3(), delta=1e-3 * cut.volume_mm3())
        self.assertAlmostEqual(bone.volume_mm3() - cut.volume_mm3(), sum(simulation.removed_by_region_mm3().values()), delta=1e-6 * 432)


class Scenes(unittest.TestCase):
    def test_keywords_make_the_same_scene_as_text(self):
        scene = kerf.Scene(bone={"model": "block", "block": {"size_x_mm": 12.0, "voxel_mm": 0.2}}, tool={"teeth": 20, "rpm": np.float64(6000)},
                           path={"stroke": [{"start_mm": [-12, 0, 3], "end_mm": (0, 0, 3), "feed_mm_per_s": 20, "disc_normal": [0, 1, 0]}]})
        text = kerf.Scene.parse(scene.toml)
        self.assertEqual(scene.resolve(), text.resolve())
        self.assertEqual(scene.rpm, 6000)
        changed = scene.with_value("bone.block", "size_x_mm", 14.5)
        self.assertIn("size_x_mm = 14.5", changed.toml)

    def test_errors_are_those_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "bad.toml"
            path.write_text("[tool]\nteth = 3\n")
            done = subprocess.run([PROGRAM, "check", str(path)], capture_output=True, text=True)
            with self.assertRaises(kerf.Error) as caught:
                kerf.Scene.read(path)
            for line in str(caught.exception).splitlines():
                self.assertIn(line, done.stderr)
            with self.assertRaisesRegex(kerf.Error, r"keywords.toml:3:1: .*teeth"):
                kerf.Scene(tool={"teth": 3})

    def test_steps_are_those_of_the_path(self):
        scene = kerf.Scene.read(ROOT / "examples/hello_cut.toml")
        steps = scene.steps()
        self.assertEqual(steps["set_down"][0], 1)
        ticks = steps[steps["set_down"] == 0]
        self.assertAlmostEqual(ticks["dt_s"].sum(), ticks["time_s"][-1])
        self.assertAlmostEqual(ticks["x_mm"][-1], 20)


class Simulations(unittest.TestCase):
    def test_hello_cut_has_the_bits_of_the_program(self):
        scene = kerf.Scene.read(ROOT / "examples/hello_cut.toml")
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([PROGRAM, "run", str(ROOT / "examples/hello_cut.toml"), "-o", folder + "/out"], check=True, capture_output=True)
            table = np.genfromtxt(folder + "/out/forces.csv", delimiter=",", names=True)
        result = kerf.run(scene)
        self.assertEqual(result.bone.hash(), "179bce485136aa5a")
        for name in table.dtype.names:  # the file has 6 to 9 digits
            np.testing.assert_allclose(result.ticks[name][::max(1, len(result.ticks) // len(table))][:len(table)], table[name], rtol=1e-5, atol=1e-6, err_msg=name)

        done = subprocess.run([sys.executable, ROOT / "examples/hello_cut.py"], capture_output=True, text=True, check=True)
        self.assertIn("179bce485136aa5a", done.stdout)
        force = np.sqrt(sum(result.ticks[f"force_{i}_N"]**2 for i in "xyz")).max()
        self.assertIn(f"peak force {force:.6g} N", done.stdout)

    def test_run_equals_ticks_bit_for_bit(self):
        one, poses = slot(small_block(), effects=["kerf_friction", "tangential_force", "heat"])
        other, _ = slot(small_block(), effects={"kerf_friction": {}, "tangential_force": {}, "heat": {}})
        table = one.run(poses)
        self.assertEqual(len(table), len(poses))
        total = 0.0
        for row, pose in zip(table, poses):
            tick = other.tick(pose)
            total += tick.removed_mm3
            np.testing.assert_array_equal(tick.force_N, [row["force_x_N"], row["force_y_N"], row["force_z_N"]])
            self.assertEqual(tick.engaged_teeth, row["engaged_teeth"])
            self.assertEqual(total, row["removed_total_mm3"])
            self.assertEqual(other.effects()["heat.peak_C"], row["heat.peak_C"])
        self.assertGreater(total, 0.5 * 2 * 12 / 2)
        self.assertEqual(one.bone().hash(), other.bone().hash())
        self.assertEqual(one.time_s, other.time_s)

    def test_slot_has_its_volume(self):
        bone = small_block(0.1)
        simulation, poses = slot(bone)
        simulation.run(np.vstack([poses, kerf.line(poses[-1], (12, 0, 3), 20)]))
        removed = bone.volume_mm3() - simulation.bone().volume_mm3()
        # 0.5 mm wide, 2 mm deep, 12 mm long; 1 % is what a voxel of 0.1 mm leaves at the edges (docs/accuracy.md).
        self.assertAlmostEqual(removed, 0.5 * 2 * 12, delta=0.01 * 12)

    def test_poses_may_be_matrices(self):
        one, poses = slot(small_block())
        other, _ = slot(small_block())
        w, x, y, z = poses[0, 3:]
        R = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                      [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                      [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
        matrices = np.tile(np.eye(4), (len(poses), 1, 1))
        matrices[:, :3, :3] = R
        matrices[:, :3, 3] = poses[:, :3]
        np.testing.assert_allclose(one.run(poses)["force_z_N"], other.run(matrices)["force_z_N"], rtol=1e-6, atol=1e-9)
        matrices[0, :3, :3] *= 2
        with self.assertRaisesRegex(kerf.Error, "not a rotation"):
            other.run(matrices)

    def test_hand_balances_its_energy_and_undoes(self):
        bone = small_block()
        start = kerf.pose((-12, 0, 3), *UPRIGHT)
        hand = kerf.HandSimulation(bone, start, tool=kerf.Disc(diameter_mm=10, thickness_mm=0.5), stiffness_N_per_mm=2, undo_MB=64)
        hand.checkpoint("before")
        before = hand.bone().hash()
        table = hand.run(kerf.line(start, (0, 0, 3), 20))
        into = table["hand_mJ"] + table["spindle_mJ"]
        out = sum(table[name] for name in ("stored_mJ", "cut_mJ", "friction_mJ", "damping_mJ", "numerical_mJ"))
        np.testing.assert_allclose(into, out, atol=1e-6)  # to the solver's accuracy
        self.assertGreater(table["removed_total_mm3"][-1], 1)
        self.assertNotEqual(hand.bone().hash(), before)
        hand.undo("before", start)
        self.assertEqual(hand.bone().hash(), before)
        hand.redo(start)
        self.assertEqual(hand.checkpoints()[0], "start")
        tick = hand.tick(start, velocity=(1, 0, 0))
        self.assertEqual(tick.fidelity, "full")

    def test_slab_agrees_with_a_run_of_its_scene(self):
        scene = kerf.Scene.read(ROOT / "scenes/paper_block.toml").with_value("simulation", "mode", "slab")
        result = kerf.run(scene)
        simulation = kerf.SlabSimulation.from_scene(scene)
        steps = scene.steps()
        ticks = steps[steps["set_down"] == 0][:2000]
        poses = np.stack([ticks[name] for name in ("x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz")], axis=1)
        table = simulation.run(poses, dt=ticks["dt_s"], rpm=scene.rpm)
        np.testing.assert_array_equal(table["force_y_N"], result.ticks["force_y_N"][:2000])
        np.testing.assert_array_equal(table["depth_mm"], result.slab["depth_mm"][:2000])
        self.assertEqual(simulation.state()["depth_mm"], table["depth_mm"][-1])

    def test_threads_run_simulations_in_parallel_and_one_at_a_time(self):
        simulation, poses = slot(small_block())
        expected = simulation.run(poses)
        results = []

        def work():
            one, _ = slot(small_block())
            results.append(one.run(poses))

        threads = [threading.Thread(target=work) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for result in results:
            np.testing.assert_array_equal(result, expected)

        # A second thread is refused while the first one runs; the callback lets it try.
        shared, poses = slot(small_block(0.1))
        refusals = []

        def try_it(fraction):
            try:
                shared.tick(poses[0])
            except kerf.Error as error:
                refusals.append(str(error))

        shared.run(np.tile(poses, (200, 1)), progress=try_it)
        self.assertTrue(refusals and "another thread" in refusals[0])

    def test_progress_is_shown_and_can_end_the_work(self):
        simulation, poses = slot(small_block())
        fractions = []

        def stop(fraction):
            fractions.append(fraction)
            raise KeyError("enough")

        with self.assertRaises(KeyError):
            simulation.run(np.tile(poses, (1000, 1)), progress=stop)
        self.assertEqual(len(fractions), 1)
        self.assertLess(fractions[0], 1)

    def test_a_thread_does_not_crash_the_end_of_the_interpreter(self):
        script = ("import kerf, numpy as np, threading, time\n"
                  "s = kerf.Simulation(kerf.Bone.block((12, 6, 6), voxel_mm=0.2), (0, 0, 9), tool=kerf.Disc(diameter_mm=10))\n"
                  "def work():\n"
                  "    while True: s.run(np.zeros((100000, 3)) + (0, 0, 9))\n"
                  "threading.Thread(target=work, daemon=True).start()\n"
                  "time.sleep(0.2)\n")
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_warnings_of_a_run_are_those_of_the_scene(self):
        scene = kerf.Scene.read(ROOT / "examples/hello_cut.toml").with_value("tool", "thickness_mm", 0.25)
        self.assertTrue(any("voxel" in warning for warning in kerf.run(scene).warnings))

    def test_stderr_may_be_missing(self):
        script = ("import sys, kerf\n"
                  "sys.stderr = None\n"
                  "kerf.run('examples/hello_cut.toml')\n"
                  "sys.stderr = open('/dev/null', 'w'); sys.stderr.close()\n"
                  "kerf.run('examples/hello_cut.toml')\n"
                  "print('fine')\n")
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=ROOT)
        self.assertEqual(done.stdout, "fine\n")

    def test_ctrl_c_ends_a_run(self):
        script = ("import kerf, numpy as np\n"
                  "s = kerf.Simulation(kerf.Bone.block((12, 6, 6), voxel_mm=0.2), (0, 0, 9), tool=kerf.Disc(diameter_mm=10))\n"
                  "print('ready', flush=True)\n"
                  "try:\n"
                  "    while True: s.run(np.zeros((1000000, 3)) + (0, 0, 9))\n"
                  "except KeyboardInterrupt:\n"
                  "    print('interrupted')\n")
        with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as process:
            self.assertEqual(process.stdout.readline(), "ready\n")
            time.sleep(0.3)
            process.send_signal(signal.SIGINT)
            self.assertEqual(process.stdout.read(), "interrupted\n")


class BadInput(unittest.TestCase):
    def test_one_sentence_each(self):
        bone = small_block()
        start = kerf.pose((0, 0, 20))
        simulation = kerf.Simulation(bone, start)
        cases = [
            (lambda: kerf.Disc(teth=3), "did you mean 'teeth'"),
            (lambda: kerf.Disc(teeth=2.5), "teeth must be a whole number"),
            (lambda: kerf.Disc(thickness_mm="thin"), "thickness_mm must be a number"),
            (lambda: kerf.Disc(thickness_mm=0), "thickness_mm = 0 is below 0.02"),
            (lambda: kerf.Simulation(bone, start, law="hertz"), "hertz"),
            (lambda: kerf.Simulation(bone, start, effects=["fog"]), "fog"),
            (lambda: kerf.Simulation(bone, start, effects={"heat": {"colour": 3}}), "colour"),
            (lambda: kerf.Simulation(bone, start, tool="saw"), "a Disc or a Ball"),
            (lambda: kerf.Simulation(bone, start, substeps=0), "substeps = 0"),
            (lambda: kerf.Simulation(bone, (0, 0, float("nan"))), "pose"),
            (lambda: kerf.HandSimulation(bone, start, stiffness=3), "stiffness_N_per_mm"),
            (lambda: simulation.tick((0, 0)), "shape"),
            (lambda: simulation.tick("here"), "array of numbers"),
            (lambda: simulation.run(np.zeros((4, 5))), r"\(4, 5\)"),
            (lambda: simulation.run(np.zeros((4, 3)), rpm=[1, 2]), "4, one for each pose"),
            (lambda: simulation.set_down((float("inf"), 0, 0)), "pose"),
            (lambda: kerf.HandSimulation(bone, start).checkpoint("a"), "undo_MB"),
            (lambda: bone.phi([1, 2, 3]), r"\(n, 3\)"),
            (lambda: bone.write("/nowhere/bone.vdb"), "/nowhere/bone.vdb"),
            (lambda: kerf.Bone.read(__file__), "module_test.py"),
            (lambda: kerf.Bone.block(size_mm=(1, 2)), "size_mm"),
            (lambda: kerf.Bone.block(layers=[(1, 300)]), "300"),
            (lambda: kerf.Bone.mandible(voxel=0.3), "did you mean 'voxel_mm'"),
            (lambda: kerf.Bone.from_file("/nowhere"), "/nowhere"),
            (lambda: kerf.Bone.from_labels(np.zeros((2, 2), dtype=np.uint8), {1: 24}), "three dimensions"),
            (lambda: kerf.Region(1, "x", "wood", 1, 0.3), "tissue"),
            (lambda: kerf.Recording(__file__), "module_test.py"),
            (lambda: kerf.Scene.read("/nowhere.toml"), "/nowhere.toml"),
            (lambda: kerf.Scene(tool={"rpm": object()}), "object"),
            (lambda: kerf.pose((0, 0, 0), (0, 0, 0), 3), "axis"),
            (lambda: kerf.line((0, 0, 0), (1, 0, 0), 0), "feed_mm_per_s"),
            (lambda: kerf.Simulation(bone, start, effects=["heet"]), "did you mean 'heat'"),
            (lambda: kerf.Simulation(bone, start, effects=[1]), "must be a text"),
            (lambda: kerf.Simulation(bone, start, effects={"heat": 3}), "must be a dict"),
            (lambda: kerf.Simulation(bone, start, law=3), "law must be a text"),
            (lambda: kerf.Simulation(bone, start, law="hertz_chip", law_parameters={"x": 1}), "no parameter of hertz_chip"),
            (lambda: kerf.Simulation(bone, start, law_parameters=[1]), "law_parameters must be a dict"),
            (lambda: kerf.HandSimulation(bone, start, undo_MB=-1), "-1"),
            (lambda: kerf.Bone.from_labels(np.full((4, 4, 4), 257), {1: 24}), "0 to 255"),
            (lambda: kerf.Bone.from_labels(np.full((4, 4, 4), 1.7), {1: 24}), "whole numbers"),
            (lambda: bone.mesh(2), "0 to 1"),
            (lambda: kerf.run(kerf.Scene(), record=""), "name of a file"),
            (lambda: kerf.run(kerf.Scene(), progress="yes"), "progress must be"),
            (lambda: kerf.pose("here"), "not an array of numbers"),
            (lambda: kerf.run(3), "a Scene or the path"),
            (lambda: kerf.run("/nowhere.toml"), "/nowhere.toml"),
            (lambda: kerf.stability("/nowhere.toml"), "/nowhere.toml"),
            (lambda: kerf.compare(ROOT / "examples/hello_cut.toml"), "slab"),
            (lambda: kerf.score("/nowhere.kerf"), "/nowhere.kerf"),
        ]
        for i, (call, expected) in enumerate(cases):
            with self.subTest(case=i, expected=expected), self.assertRaisesRegex(kerf.Error, expected) as caught:
                call()
            self.assertLess(str(caught.exception).count("\n"), 2)

    def test_bad_pose_is_a_status_not_an_exception(self):
        simulation, poses = slot(small_block())
        bad = poses.copy()
        bad[5] = float("nan")
        table = simulation.run(bad)
        self.assertEqual(table["status"][5], 1)
        before = simulation.time_s
        for dt in (-1, float("nan")):
            self.assertEqual(simulation.tick(poses[-1], dt=dt).status, 1)
        self.assertEqual(simulation.time_s, before)
        self.assertEqual(table["force_z_N"][5], 0)


class Recordings(unittest.TestCase):
    def test_recording_is_read_and_replayed(self):
        scene = kerf.Scene.read(ROOT / "examples/hello_cut.toml")
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "cut.kerf"
            result = kerf.run(scene, record=path)
            recording = kerf.Recording(path)
            self.assertEqual((recording.kind, recording.damage, len(recording)), ("run", "", 1 + len(result.ticks)))
            inputs = recording.inputs()
            ticks = inputs[inputs["set_down"] == 0]
            np.testing.assert_array_equal(ticks["x_mm"], result.ticks["x_mm"])
            again = recording.replay()
            self.assertIsNone(again.difference)
            self.assertEqual(again.bone.hash(), result.bone.hash())
            self.assertEqual(recording.scene.resolve(), scene.resolve())
            with self.assertRaisesRegex(kerf.Error, "exists"):
                kerf.run(scene, record=path)

    def test_hand_gives_the_same_bits_each_time(self):
        scene = kerf.Scene.read(ROOT / "scenes/hand_held_cut.toml")
        first, second = (kerf.run_in_hand(scene, seconds=0.2) for _ in range(2))
        np.testing.assert_array_equal(first.ticks, second.ticks)
        self.assertEqual(len(first.ticks), round(0.2 * scene.rate_hz))


class Frames(unittest.TestCase):
    def test_table_becomes_a_frame(self):
        try:
            import pandas  # noqa: F401
        except ImportError:
            with self.assertRaisesRegex(kerf.Error, "pandas"):
                kerf.to_frame(np.zeros(1, dtype=[("a", "f8")]))
            return
        simulation, poses = slot(small_block())
        table = simulation.run(poses)
        frame = kerf.to_frame(table)
        self.assertEqual(list(frame.columns), list(table.dtype.names))
        self.assertEqual(frame["force_z_N"].min(), table["force_z_N"].min())


PROGRAM = os.environ.get("KERF_PROGRAM", str(ROOT / "build/release/kerf"))

if __name__ == "__main__":
    unittest.main()
