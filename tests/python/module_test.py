"""Tests of the Python module kerf: python3 -m unittest, with the build's python folder in PYTHONPATH (ctest -R python)."""

import concurrent.futures
import contextlib
import copy
import fcntl
import gc
import io
import json
import math
import os
import pathlib
import pickle
import pty
import re
import signal
import struct
import subprocess
import sys
import tempfile
import termios
import threading
import time
import unittest
import warnings

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

    def test_mask_selects_a_bone_of_a_ct(self):
        z, y, x = np.mgrid[-12:13, -12:13, -30:31]
        wanted, other = (x + 12)**2 + y**2 + z**2 < 100, (x - 12)**2 + y**2 + z**2 < 100
        header = ("NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: 61 25 25\n"
                  "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (-30,-12,-12)\nendian: little\nencoding: raw\n\n")
        with tempfile.TemporaryDirectory() as folder:
            ct, mask = pathlib.Path(folder) / "ct.nrrd", pathlib.Path(folder) / "mask.nrrd"
            ct.write_bytes(header.encode() + np.where(wanted | other, 900, -1000).astype("<i2").tobytes())
            mask.write_bytes(header.encode() + np.where(wanted, 2, np.where(other, 1, 0)).astype("<i2").tobytes())
            bone, _ = kerf.Bone.from_file(ct, voxel_mm=0.5, mask=mask, mask_labels="dentalsegmentator")
            # A ball of 10 mm, whose surface lies within half a voxel of the CT.
            self.assertAlmostEqual(bone.volume_mm3(), 4 / 3 * math.pi * 1000, delta=4 * math.pi * 100 * 0.5)
            self.assertLess(bone.bounds_mm()[1][0], 0)
            same, _ = kerf.Bone.from_file(ct, voxel_mm=0.5, mask=str(mask), mask_label={2: "mandible", 1: "other"})
            self.assertEqual(same.hash(), bone.hash())
            alone, report = kerf.Bone.from_file(None, voxel_mm=0.5, mask=mask, mask_labels="dentalsegmentator")
            self.assertLess(alone.bounds_mm()[1][0], 0)
            self.assertTrue(any("without a CT" in warning for warning in report["warnings"]))
            for wrong, words in (({"mask": 3}, "mask must be the name of a file"), ({"mask": mask}, "does not say what its labels are"),
                                 ({"mask": mask, "mask_label": ["2=mandible"]}, "mask_label must be a dict"),
                                 ({"mask_reach_mm": 2}, "apply to a mask only")):
                with self.assertRaisesRegex(kerf.Error, words):
                    kerf.Bone.from_file(ct, **wrong)

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

    def test_a_tool_turns_in_its_sense_unless_a_speed_is_given(self):
        for tool, rpm in ((kerf.Disc(), 7500), (kerf.Drill(), -1000)):
            def torque(**speed):
                simulation = kerf.Simulation(small_block(), (0, 0, 1), tool=tool, effects="tangential_force")
                return simulation.run([(0, 0, 1 - 0.01 * i) for i in range(150)], **speed)["torque_z_Nmm"]
            np.testing.assert_array_equal(torque(), torque(rpm=rpm))
        self.assertGreater(np.abs(torque()).max(), 0)  # of the drill
        self.assertGreater(np.abs(torque() - torque(rpm=1000)).max(), 0)
        scene = kerf.Scene.read(ROOT / "scenes/bur_groove.toml")
        bone = scene.bone()
        steps = scene.steps()[:1500]
        poses = np.stack([steps[name] for name in ("x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz")], axis=1)
        thrust = [kerf.Simulation.from_scene(scene, bone).run(poses, **speed)["thrust_sum_N"].sum()
                  for speed in ({}, {"rpm": scene.rpm}, {"rpm": -7500})]
        self.assertEqual(thrust[0], thrust[1])
        self.assertNotEqual(thrust[0], thrust[2])

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
                  "poses = np.zeros((100000, 3)) + (0, 0, 9)\n"  # not in the thread: NumPy releases the interpreter's lock, too
                  "def work():\n"
                  "    while True: s.run(poses)\n"
                  "threading.Thread(target=work, daemon=True).start()\n"
                  "time.sleep(0.2)\n")
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_warnings_of_a_run_are_those_of_the_scene(self):
        scene = kerf.Scene.read(ROOT / "examples/hello_cut.toml").with_value("tool", "thickness_mm", 0.25)
        self.assertTrue(any("voxel" in warning for warning in kerf.run(scene).warnings))

    def test_warnings_are_those_of_the_program(self):
        hello = (ROOT / "examples/hello_cut.toml").read_text()
        fast = kerf.Scene.parse(hello.replace("feed_mm_per_s = 10", "feed_mm_per_s = 60"))
        stalls = kerf.Scene.parse(hello + "\n[effects.tangential_force]\n\n[effects.spindle]\nstall_torque_Nmm = 6\n")
        for scene, expected in ((fast, "bite"), (stalls, "stalled")):
            with self.subTest(expected=expected), tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder) / "scene.toml"
                path.write_text(scene.toml)
                subprocess.run([PROGRAM, "run", str(path), "-o", folder + "/out"], check=True, capture_output=True)
                warnings = json.loads((pathlib.Path(folder) / "out/summary.json").read_text())["warnings"]
                self.assertTrue(any(expected in warning for warning in warnings), warnings)
                self.assertEqual(kerf.run(scene).warnings, warnings)

    def test_ticks_of_ones_own_have_the_warnings_of_the_run(self):
        hello = (ROOT / "examples/hello_cut.toml").read_text()
        stalls = "\n[effects.tangential_force]\n\n[effects.spindle]\nstall_torque_Nmm = 6\n"
        seen = set()
        for text in (hello.replace("feed_mm_per_s = 10", "feed_mm_per_s = 40"),  # the bite is too large
                     hello.replace("feed_mm_per_s = 10", "feed_mm_per_s = 5").replace("thickness_mm = 0.5", "thickness_mm = 0.15"),
                     hello + '\n[force]\nlaw = "hertz_constant_bite"\n',
                     hello.replace("start_mm = [-20, 0, 8]", "start_mm = [0, 0, 5]"),  # within the bone
                     hello + stalls):
            scene = kerf.Scene.parse(text)
            steps = scene.steps()[1:]
            poses = np.stack([steps[name] for name in ("x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz")], axis=1)
            simulation = kerf.Simulation.from_scene(scene)
            for pose, dt in zip(poses[:500], steps["dt_s"]):
                simulation.tick(pose, dt, scene.rpm)
            simulation.run(poses[500:], steps["dt_s"][500:], scene.rpm)
            warnings = kerf.run(scene).warnings
            self.assertEqual(simulation.warnings, warnings)
            seen.update(warnings)
        for words in ("the bite reaches", "thinner than a voxel", "inside the bone", "specific cutting energy", "stalled"):
            self.assertTrue(any(words in warning for warning in seen), (words, seen))

    def test_examples_of_the_documentation_run_without_a_warning(self):
        for page in ("README.md", "docs/python.md"):
            example = re.search("```py\n(import .*?)```", (ROOT / page).read_text(), re.DOTALL).group(1)
            with self.subTest(page), warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()) as shown:
                warnings.simplefilter("error")
                names = {}
                exec(example, names)
                self.assertGreater(float(shown.getvalue().split()[0]), 0.1)

    def test_each_warning_is_shown_once(self):
        simulation, poses = slot(small_block(0.4))
        with warnings.catch_warnings(record=True) as shown:
            warnings.simplefilter("always")
            simulation.tick(poses[0])
            simulation.run(poses)
            self.assertEqual([str(w.message) for w in shown], simulation.warnings)
            simulation.run(poses[::-1])  # its numbers differ
        self.assertEqual(len(shown), len({re.sub("[0-9]", "", warning) for warning in simulation.warnings}))
        self.assertEqual({w.filename for w in shown}, {__file__})

    def test_warnings_grow_with_the_ticks(self):
        simulation, poses = slot(small_block())
        self.assertEqual(simulation.warnings, [])
        simulation.run(poses[:5])
        self.assertEqual(simulation.warnings, ["the saw touched no bone on its path"])
        simulation.run(poses[5:], rpm=0)
        self.assertIn(f"{len(poses) - 5} ticks report", " ".join(simulation.warnings))
        coarse, _ = slot(small_block(voxel_mm=0.4))
        self.assertIn("1.25 voxels thick", coarse.warnings[0])

    def test_a_hand_and_a_slab_have_warnings(self):
        bone = small_block(voxel_mm=0.4)
        start = kerf.pose((-3, 0, 6), *UPRIGHT)
        hand = kerf.HandSimulation(bone, start, tool=kerf.Disc(diameter_mm=10, thickness_mm=0.5))
        self.assertEqual(len(hand.warnings), 1)
        self.assertIn("1.25 voxels thick", hand.warnings[0])
        for _ in range(3):
            hand.tick(start)
        self.assertEqual(hand.warnings[1:], ["the tool touched no bone"])
        deep = kerf.HandSimulation(bone, kerf.pose((0, 0, 1), *UPRIGHT), tool=kerf.Disc(diameter_mm=10, thickness_mm=0.5))
        deep.tick(kerf.pose((0, 0, 1), *UPRIGHT))
        self.assertIn("set down inside the bone", " ".join(deep.warnings))
        scene = kerf.Scene.read(ROOT / "scenes/paper_block.toml").with_value("simulation", "mode", "slab")
        slab = kerf.SlabSimulation.from_scene(scene)
        run = kerf.run(scene)
        steps = scene.steps()[1:]
        slab.run(np.stack([steps[name] for name in ("x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz")], axis=1),
                 dt=steps["dt_s"], rpm=scene.rpm)
        self.assertEqual(slab.warnings, run.warnings)

    def test_a_forked_child_can_exit(self):
        # At its end, a child would wait forever for threads that the fork did not copy, and for the parent's run.
        script = ("import kerf, numpy as np, os, signal, sys, threading, time\n"
                  "bone = kerf.Bone.block((12, 6, 6), voxel_mm=0.2, progress=False)\n"
                  "simulation = kerf.Simulation(bone, (0, 0, 9), tool=kerf.Disc(diameter_mm=10))\n"
                  "begun = threading.Event()\n"
                  "if sys.argv[1] == 'busy':\n"
                  "    def run():\n"
                  "        while True: simulation.run(np.zeros((10**5, 3)) + (0, 0, 9), progress=lambda fraction: begun.set())\n"
                  "    threading.Thread(target=run, daemon=True).start()\n"
                  "    begun.wait()\n"
                  "child = os.fork()\n"
                  "if child == 0:\n"
                  "    assert kerf.Bone.block((12, 6, 6), voxel_mm=0.2, progress=False).hash() == bone.hash()\n"
                  "    sys.exit(3)\n"
                  "for _ in range(1200):\n"
                  "    pid, status = os.waitpid(child, os.WNOHANG)\n"
                  "    if pid: os._exit(os.waitstatus_to_exitcode(status))\n"  # the thread must not outlive the interpreter
                  "    time.sleep(0.1)\n"
                  "os.kill(child, signal.SIGKILL)\n"
                  "sys.exit('the child hangs')\n")
        for what in ("idle", "busy"):
            done = subprocess.run([sys.executable, "-c", script, what], capture_output=True, text=True)
            self.assertEqual(done.returncode, 3, (what, done.stderr))

    def test_bar_fits_into_the_terminals_line(self):
        script = ("import kerf, sys\n"
                  "from kerf import _progress\n"
                  "_progress._DELAY_S = -1\n"
                  "bar = _progress.make(None, 'run in hand')\n"
                  "for i in range(101):\n"
                  "    bar(i / 100)\n"
                  "    bar(i / 100)\n"  # nothing new
                  "bar.end()\n"
                  "print('end', file=sys.stderr)\n")
        for columns in (100, 45, 15, 5, 0):
            with self.subTest(columns=columns):
                controller, terminal = pty.openpty()
                fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("4H", 25, columns, 0, 0))
                with subprocess.Popen([sys.executable, "-c", script], stderr=terminal) as process:
                    os.close(terminal)
                    shown = b""
                    try:
                        while part := os.read(controller, 4096):
                            shown += part
                    except OSError:  # the process has ended
                        pass
                    self.assertEqual(process.wait(), 0)
                os.close(controller)
                drawn, end = shown.decode().removesuffix("\r\n").rsplit("\r", 1)
                self.assertEqual(end, "end")
                lines = drawn.removeprefix("\r").split("\r")
                widest = max(len(line) for line in lines)
                self.assertLessEqual(widest, columns - 1 if columns else 80)
                self.assertEqual(lines[-1].strip(), "")  # it is removed
                self.assertNotIn("\n", drawn)
                self.assertTrue(all(one != next for one, next in zip(lines, lines[1:])))
                if columns == 100:
                    half = "run in hand [" + 15 * "#" + 15 * "." + "]  50 %, "
                    self.assertTrue(any(line.startswith(half) and line.rstrip().endswith(" s left") for line in lines))

    def test_progress_grows_to_1(self):
        def check(work):
            fractions = []
            result = work(fractions.append)
            self.assertEqual(fractions, sorted(fractions))
            self.assertEqual(fractions[-1], 1)
            self.assertGreaterEqual(fractions[0], 0)
            return result

        scene = kerf.Scene.read(ROOT / "scenes/hand_held_cut.toml")
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "hand.kerf"
            check(lambda show: kerf.run_in_hand(scene, seconds=2, record=path, progress=show))
            check(lambda show: kerf.Recording(path).replay(progress=show))
        check(lambda show: kerf.run(ROOT / "examples/hello_cut.toml", progress=show))
        check(lambda show: kerf.run(ROOT / "examples/hello_cut.toml", bone=small_block(), progress=show))
        check(lambda show: kerf.Bone.block((12, 6, 6), voxel_mm=0.1, progress=show))
        simulation, poses = slot(small_block())
        check(lambda show: simulation.run(poses, progress=show))

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


    def test_a_progress_function_that_raises_ends_runs_in_threads(self):
        stop = threading.Event()

        def check(_):
            if stop.is_set():
                raise InterruptedError

        def run_for_hours():
            simulation = kerf.Simulation(small_block(), (0, 0, 9), tool=kerf.Disc(diameter_mm=10))
            while True:
                simulation.run(np.zeros((1000000, 3)) + (0, 0, 9), progress=check)

        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            runs = [pool.submit(run_for_hours) for _ in range(2)]
            stop.set()
            for each in runs:
                self.assertIsInstance(each.exception(), InterruptedError)

    def test_ctrl_c_ends_the_making_of_a_bone(self):
        makers = {
            "block": "kerf.Bone.block((200, 200, 200), voxel_mm=0.1)",  # takes minutes
            "plate": "kerf.Bone.plate(voxel_mm=0.02)",
            "labels": "kerf.Bone.from_labels(np.random.default_rng(1).integers(0, 2, (150, 150, 150)), {1: 24}, voxel_mm=0.2)",
        }
        for name, maker in makers.items():
            script = ("import kerf, numpy as np, time\n"
                      "print('ready', flush=True)\n"
                      "try:\n"
                      f"    {maker}\n"
                      "    print('made')\n"
                      "except KeyboardInterrupt:\n"
                      "    print('interrupted')\n")
            with self.subTest(name), subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as process:
                self.assertEqual(process.stdout.readline(), "ready\n")
                time.sleep(0.5)
                process.send_signal(signal.SIGINT)
                self.assertEqual(process.stdout.read(), "interrupted\n")


class Copies(unittest.TestCase):
    def assert_same_bone(self, one, other):
        self.assertEqual((one.hash(), one.notes, one.materials.csv()), (other.hash(), other.notes, other.materials.csv()))

    def test_pickles_keep_every_bit(self):
        bone = small_block()
        cut = kerf.run(ROOT / "examples/hello_cut.toml")
        self.assert_same_bone(pickle.loads(pickle.dumps(bone)), bone)
        self.assert_same_bone(pickle.loads(pickle.dumps(cut.bone)), cut.bone)
        soft = bone.with_materials(bone.materials.uniform(9000, 0.3))
        self.assert_same_bone(pickle.loads(pickle.dumps(soft)), soft)
        # A uniform material overrides that of the bone's file.
        uniform = kerf.Scene(bone={"model": "block"}, material={"kind": "uniform", "E_GPa": 9.0},
                             path={"stroke": [{"start_mm": [-12, 0, 3], "end_mm": [0, 0, 3], "feed_mm_per_s": 20,
                                               "disc_normal": [0, 1, 0]}]}).bone()
        self.assertEqual(uniform.materials[24].E_MPa, 9000)
        self.assert_same_bone(pickle.loads(pickle.dumps(uniform)), uniform)

        again = pickle.loads(pickle.dumps(cut))
        np.testing.assert_array_equal(again.ticks, cut.ticks)
        self.assertEqual((again.removed_by_region_mm3, again.warnings), (cut.removed_by_region_mm3, cut.warnings))
        for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
            self.assert_same_bone(pickle.loads(pickle.dumps(bone, protocol)), bone)
            self.assertEqual(pickle.loads(pickle.dumps(kerf.Disc(teeth=31), protocol)).teeth, 31)
        disc = pickle.loads(pickle.dumps(kerf.Disc(teeth=31, thickness_mm=0.3)))
        self.assertEqual((disc.teeth, disc.thickness_mm), (31, 0.3))
        self.assertEqual(pickle.loads(pickle.dumps(kerf.Ball(flutes=9))).flutes, 9)

    def test_tools_show_all_their_parameters(self):
        self.assertEqual(repr(kerf.Disc(teeth=31, nu=0.3)),
                         "kerf.Disc(diameter_mm=22.0, thickness_mm=0.25, teeth=31, nu=0.3)")
        self.assertEqual(kerf.Disc.teeth.__doc__, "number of teeth, evenly spaced on the rim")
        shape = {"diameter_mm": 9.5, "rake_deg": -5.0, "edge_radius_um": 3.0, "E_MPa": 2e5, "nu": 0.3, "grip_mm": (1, 2, 3)}
        for tool in (kerf.Disc(**shape, thickness_mm=0.4, teeth=31), kerf.Ball(**shape, flutes=9, tooth_width_mm=0.7)):
            for same in (pickle.loads(pickle.dumps(tool)), eval(repr(tool))):  # pylint: disable=eval-used
                self.assertEqual(repr(same), repr(tool))
            for key, value in shape.items():
                np.testing.assert_array_equal(getattr(tool, key), value)
            with self.assertRaises(AttributeError):
                tool.nu = 0.2

    def test_moduli_of_a_ct_are_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            # A CT of a ball of cancellous bone, with a radius of 7 mm.
            z, y, x = np.mgrid[-12:13, -12:13, -12:13] * 0.7
            hu = np.where(x**2 + y**2 + z**2 < 49, 600, -1000).astype("<i2")
            header = ("NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: 25 25 25\n"
                      "space directions: (0.7,0,0) (0,0.7,0) (0,0,0.7)\nspace origin: (-8.4,-8.4,-8.4)\n"
                      "endian: little\nencoding: raw\n\n")
            ct = pathlib.Path(folder) / "ct.nrrd"
            ct.write_bytes(header.encode() + hu.tobytes())
            bone, _ = kerf.Bone.from_file(ct, voxel_mm=0.4, isolate=False, keep_hu=True)
            bone.write(pathlib.Path(folder) / "bone.vdb")
            scene = kerf.Scene.parse('[bone]\nfile = "bone.vdb"\n[material]\nkind = "ct"\nct_law = "mandible_matmap"\n'
                                     '[[path.stroke]]\nstart_mm = [-20, 0, 8]\nend_mm = [-16, 0, 8]\nfeed_mm_per_s = 20\n'
                                     'disc_normal = [0, 1, 0]\n', pathlib.Path(folder) / "scene.toml")
            self.assert_same_bone(pickle.loads(pickle.dumps(bone)), bone)
            graded = scene.bone()
            self.assertNotEqual(graded.modulus(np.zeros((1, 3)))[0], bone.modulus(np.zeros((1, 3)))[0])
            for thing in (graded, kerf.run(scene)):
                with self.assertRaisesRegex(TypeError, "^a bone whose moduli come from a CT cannot be pickled"):
                    pickle.dumps(thing)
            self.assertEqual(pickle.loads(pickle.dumps(scene)).bone().hash(), graded.hash())

    def test_labels_that_do_not_fit_in_memory(self):
        code = """
import resource
import kerf, numpy
resource.setrlimit(resource.RLIMIT_AS, (1_500_000_000, 1_500_000_000))
try:
    kerf.Bone.from_labels(numpy.broadcast_to(numpy.uint8(1), (1000, 1000, 1500)), {1: 24}, voxel_mm=1)
except MemoryError:
    print("refused")"""
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (0, "refused\n"), done.stderr)

    def test_a_pickled_scene_finds_its_files(self):
        here = os.getcwd()
        with tempfile.TemporaryDirectory() as folder:
            try:
                os.chdir(folder)
                small_block().write("bone.vdb")
                pathlib.Path("scene.toml").write_text((ROOT / "examples/hello_cut.toml").read_text().split("[bone]")[0] +
                                                      '[bone]\nfile = "bone.vdb"\n\n[[path.stroke]]\nstart_mm = [-12, 0, 3]\n'
                                                      'end_mm = [0, 0, 3]\nfeed_mm_per_s = 20\ndisc_normal = [0, 1, 0]\n')
                scene = kerf.Scene.read("scene.toml")
                data = pickle.dumps(scene)
                os.chdir(here)
                again = pickle.loads(data)
            finally:
                os.chdir(here)
            self.assertEqual(again.resolve(), scene.resolve())
            self.assertEqual(again.bone().hash(), small_block().hash())

    def test_what_cannot_change_is_not_copied(self):
        for thing in (small_block(), kerf.Scene(), kerf.Disc(), kerf.Materials.default(), kerf.Materials.default()[24]):
            self.assertIs(copy.copy(thing), thing)
            self.assertIs(copy.deepcopy([thing])[0], thing)

    def test_simulations_are_refused(self):
        simulation, _ = slot(small_block())
        for work in (pickle.dumps, lambda x: pickle.dumps(x, 0), lambda x: x.__reduce__(), copy.copy, copy.deepcopy):
            with self.assertRaisesRegex(TypeError, "^cannot pickle .*Simulation' object$"):
                work(simulation)

    def test_objects_without_init_are_refused(self):
        bone = small_block()
        calls = [
            lambda: repr(kerf.Bone.__new__(kerf.Bone)),
            lambda: kerf.Bone.__new__(kerf.Bone).leaves(),
            lambda: kerf.run(kerf.Scene.__new__(kerf.Scene)),
            lambda: kerf.Recording.__new__(kerf.Recording).kind,
            lambda: kerf.Run.__new__(kerf.Run).ticks,
            lambda: kerf.Simulation.__new__(kerf.Simulation).tick((0, 0, 0)),
            lambda: kerf.Simulation(bone, (0, 0, 9), tool=kerf.Disc.__new__(kerf.Disc)),
            lambda: kerf.Materials.__new__(kerf.Materials)[24],
            lambda: kerf.Disc.__new__(kerf.Disc).teeth,
            lambda: repr(kerf.Ball.__new__(kerf.Ball)),
        ]
        for i, call in enumerate(calls):
            with self.subTest(case=i), self.assertRaisesRegex(TypeError, "__init__ was not called"):
                call()

    def test_bone_arguments_without_init_are_refused(self):
        empty = kerf.Bone.__new__(kerf.Bone)
        scene = kerf.Scene.read(ROOT / "examples/hello_cut.toml")
        slab = kerf.Scene.read(ROOT / "scenes/slab_mandible.toml")
        calls = [
            lambda: kerf.Simulation(empty, (0, 0, 9)),
            lambda: kerf.HandSimulation(empty, (0, 0, 9)),
            lambda: kerf.Simulation.from_scene(scene, bone=empty),
            lambda: kerf.HandSimulation.from_scene(scene, bone=empty),
            lambda: kerf.SlabSimulation.from_scene(slab, bone=empty),
            lambda: kerf.run(scene, bone=empty),
        ]
        for i, call in enumerate(calls):
            with self.subTest(case=i), self.assertRaisesRegex(TypeError, "__init__ was not called"):
                call()
        for call in (lambda: kerf.Simulation(None, (0, 0, 9)), lambda: kerf.HandSimulation(None, (0, 0, 9)),
                     lambda: kerf.Bone.volume_mm3(None), lambda: kerf.Bone.region_volumes_mm3(None), lambda: kerf.Bone.memory_bytes(None)):
            with self.assertRaises(TypeError):
                call()


class FileNames(unittest.TestCase):
    def test_need_not_be_utf8(self):
        with tempfile.TemporaryDirectory() as plain:
            folder = os.fsencode(plain) + b"/\xff"
            os.mkdir(folder)
            bone = small_block()
            bone.write(folder + b"/\xfe.vdb")
            self.assertEqual(kerf.Bone.read(os.fsdecode(folder + b"/\xfe.vdb")).hash(), bone.hash())
            scene_file = folder + b"/\xfe.toml"
            with open(scene_file, "wb") as file:
                file.write((ROOT / "examples/hello_cut.toml").read_bytes())
            scene = kerf.Scene.read(scene_file)
            self.assertEqual(os.fsencode(scene.path), scene_file)
            self.assertEqual((scene.name, repr(scene)), ("\\xfe", "<kerf.Scene '\\xfe'>"))
            result = kerf.run(scene_file, record=folder + b"/cut.kerf")
            recording = pickle.loads(pickle.dumps(kerf.Recording(folder + b"/cut.kerf")))
            self.assertEqual(recording.replay().bone.hash(), result.bone.hash())
            with self.assertRaisesRegex(kerf.Error, r"\\xff/x.toml: there is no such file"):
                kerf.Scene.read(folder + b"/x.toml")
            with self.assertRaisesRegex(kerf.Error, "not valid Unicode"):
                kerf.Scene(bone={"file": os.fsdecode(folder + b"/\xfe.vdb")})


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
            (lambda: kerf.Simulation(bone, start, tool="saw"), "tool must be a Disc, a Ball, a Bur, a Drill, a ReciprocatingBlade, a OscillatingBlade or a PiezoInsert"),
            (lambda: kerf.Simulation(bone, start, substeps=0), "substeps = 0"),
            (lambda: kerf.Simulation(bone, (0, 0, float("nan"))), "pose"),
            (lambda: kerf.HandSimulation(bone, start, stiffness=3), "stiffness_N_per_mm"),
            (lambda: simulation.tick((0, 0)), "shape"),
            (lambda: simulation.tick("here"), "array of numbers"),
            (lambda: simulation.run(np.zeros((4, 5))), r"\(4, 5\)"),
            (lambda: simulation.run(np.zeros((4, 3)), rpm=[1, 2]), "4, one for each pose"),
            (lambda: simulation.run(np.zeros((4, 3)), rpm=float("nan")), "rpm = nan"),
            (lambda: simulation.tick((0, 0, 0), rpm=-2e9), "rpm = -2"),
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
            (lambda: kerf.pose((0, 0, math.nan)), r"position_mm = .* must be finite"),
            (lambda: kerf.pose((0, 0, 0), angle_deg=math.nan), "angle_deg = nan .* -1e.06 to 1e.06"),
            (lambda: kerf.line((0, 0, 0), (1, 0, 0), 0), "feed_mm_per_s = 0 .* valid range 1e-06 to 1e.06"),
            (lambda: kerf.line((0, 0, 0), (1, 0, 0), math.inf), "feed_mm_per_s = inf"),
            (lambda: kerf.line((0, 0, 0), (1, 0, 0), math.nan), "feed_mm_per_s = nan"),
            (lambda: kerf.line((0, 0, 0), (1, 0, 0), "fast"), "feed_mm_per_s = 'fast' is not a number"),
            (lambda: kerf.line((0, 0, 0), (1, 0, 0), 1, dt=2), "dt = 2 .* valid range 1e-06 to 1$"),
            (lambda: kerf.line((0, 0, 0), (0, 0, math.nan), 1), "finite"),
            (lambda: kerf.line((0, 0, 0), (1e300, 0, 0), 1), "at most 10000000"),
            (lambda: kerf.line((0, 0, 0), (8, 0, 0), 1e-6), r"8e.09 poses; at most 10000000"),
            (lambda: kerf.Simulation(bone, start, effects=["heet"]), "did you mean 'heat'"),
            (lambda: kerf.Simulation(bone, start, effects=[1]), "must be a text"),
            (lambda: kerf.Simulation(bone, start, effects={"heat": 3}), "must be a dict"),
            (lambda: kerf.Simulation(bone, start, law=3), "law must be a text"),
            (lambda: kerf.Simulation(bone, start, law="hertz_chip", law_parameters={"x": 1}), "no parameter of hertz_chip"),
            (lambda: kerf.Simulation(bone, start, law_parameters=[1]), "law_parameters must be a dict"),
            (lambda: kerf.HandSimulation(bone, start, undo_MB=-1), "undo_MB = -1.0 is out of range; valid range 0.2 to 1000000, or 0"),
            (lambda: kerf.Bone.from_labels(np.full((4, 4, 4), 257), {1: 24}), "0 to 255"),
            (lambda: kerf.Bone.from_labels(np.full((4, 4, 4), 1.7), {1: 24}), "whole numbers of an integer type, not float64"),
            (lambda: bone.mesh(2), "0 to 1"),
            (lambda: kerf.run(kerf.Scene(), record=""), "name of a file"),
            (lambda: kerf.run_in_hand(kerf.Scene(), record=""), "name of a file"),
            (lambda: bone.phi(np.zeros((1, 3), dtype=complex)), "real numbers"),
            (lambda: kerf.Materials([]), "at least one Region"),
            (lambda: kerf.Bone.from_file("/nowhere", unit="mm"), "^from_file has no parameter 'unit'; .*keep, drop, mask, mask_label$"),
            (lambda: kerf.Bone.read(""), "name of a file"),
            (lambda: kerf.run(kerf.Scene(), progress="yes"), "progress must be"),
            (lambda: kerf.pose("here"), "not an array of numbers"),
            (lambda: kerf.run(3), "a Scene or the path"),
            (lambda: kerf.run("/nowhere.toml"), "/nowhere.toml"),
            (lambda: kerf.stability("/nowhere.toml"), "/nowhere.toml"),
            (lambda: kerf.SlabSimulation.from_scene(kerf.Scene.read(ROOT / "examples/hello_cut.toml")), r"the scene has no \[slab\]"),
            (lambda: kerf.compare(ROOT / "examples/hello_cut.toml"), "slab"),
            (lambda: kerf.score("/nowhere.kerf"), "/nowhere.kerf"),
        ]
        for i, (call, expected) in enumerate(cases):
            with self.subTest(case=i, expected=expected), self.assertRaisesRegex(kerf.Error, expected) as caught:
                call()
            self.assertLess(str(caught.exception).count("\n"), 2)

    def test_keyword_that_is_not_unicode_is_an_error(self):
        simulation = kerf.Simulation(small_block(), kerf.pose((0, 0, 20)))
        for call in (simulation.tick, simulation.run, kerf.Bone.block, kerf.run):
            with self.assertRaises((TypeError, UnicodeError)):
                call(**{"a\udc80": 1})

    def test_calls_with_wrong_arguments_get_one_sentence(self):
        bone = small_block()
        start = kerf.pose((0, 0, 20))
        simulation = kerf.Simulation(bone, start)
        made_without = {name: getattr(kerf, name).__new__(getattr(kerf, name)) for name in ("Region", "Bone", "Run", "Scene")}
        cases = [
            (lambda: kerf.Bone.block(voxel=1), "Bone.block() has no argument 'voxel'; did you mean 'voxel_mm'?"),
            (lambda: kerf.Bone.block(voxel_mm="0.1"), "voxel_mm must be a number, not '0.1'"),
            (lambda: kerf.Bone.block(layers=[2.5, 24]),
             "layers must be a list of pairs (thickness in mm, number of the region), not [2.5, 24]"),
            (lambda: kerf.Bone.block(layers=[(2.5, "cortical")]),
             "layers must be a list of pairs (thickness in mm, number of the region), not [(2.5, 'cortical')]"),
            (lambda: kerf.Disc(22), "Disc() takes no argument without a name, not 1"),
            (lambda: kerf.Scene("a.toml"), "Scene() takes no argument without a name, not 1"),
            (lambda: simulation.tick(), "Simulation.tick() needs the argument pose"),
            (lambda: simulation.tick(start, dt="a"), "dt must be a number, not 'a'"),
            (lambda: simulation.tick(start, np.zeros((3, 2))), "dt must be a number, not an array of shape (3, 2)"),
            (lambda: simulation.tick(start, pose=start), "Simulation.tick() has two values for pose"),
            (lambda: simulation.tick(start, 1, 2, 3), "Simulation.tick() takes at most 3 arguments without a name, not 4"),
            (lambda: simulation.run(start, feed=3), "Simulation.run() has no argument 'feed'; there are poses, dt, rpm, progress"),
            (lambda: kerf.Simulation(), "Simulation() needs the argument bone"),
            (lambda: kerf.Simulation("bone", start), "bone must be a kerf.Bone, not 'bone'"),
            (lambda: kerf.Simulation.from_scene("a.toml"), "scene must be a kerf.Scene, not 'a.toml'"),
            (lambda: kerf.run(kerf.Scene(), bone="x" * 1000), "bone must be a kerf.Bone or None, not '" + "x" * 56 + "..."),
            (lambda: kerf.Materials(["a"]), "regions must be a list of Region, not ['a']"),
            (lambda: kerf.Region(1, 2, "tooth", 1, 0.3), "name must be a text, not 2"),
            (lambda: bone.write(3), "path must be the name of a file, not 3"),
            (lambda: kerf.to_frame(3), "table must be a structured array, such as Run.ticks, not 3"),
            (lambda: kerf.Bone(), "Bone() can't be called; make a bone with Bone.block(), plate(), mandible(), from_file(), "
                                  "from_labels() or read()"),
            (lambda: kerf.Tick(), "Tick() can't be called; Simulation.tick() returns it"),
            (lambda: made_without["Region"].__setstate__(5), "the state must be a tuple, not 5"),
        ]
        for call, expected in cases:
            with self.subTest(expected=expected), self.assertRaises(TypeError) as caught:
                call()
            self.assertEqual(str(caught.exception), expected)

    def test_forged_pickles_are_refused(self):
        good = kerf.Region(3, "a", "tooth", 100, 0.3).__getstate__()
        cases = [(kerf.Region, good[:2] + (99,) + good[3:], "not the state of a pickled Region"),
                 (kerf.Region, good[:3] + (math.nan,) + good[4:], "E = nan"),
                 (kerf.Region, good[:4] + (0.7,) + good[5:], "nu = 0.7"),
                 (kerf.Region, (999,) + good[1:], "999"),
                 (kerf.Region, (3,), "not the state of a pickled Region"),
                 (kerf.Materials, ([1], None), "not the state of a pickled Materials"),
                 (kerf.Bone, (1, 2), "not the state of a pickled Bone"),
                 (kerf.Bone, (b"abc", kerf.Materials.default()), "^the pickled bone: not a valid OpenVDB file"),
                 (kerf.Run, (1,), "not the state of a pickled Run"),
                 (kerf.Scene, (1, 2), "not the state of a pickled Scene"),
                 (kerf.Scene, ("", b"a\0b"), "not the state of a pickled Scene"),
                 (kerf.Recording, b"", "not the state of a pickled Recording"),
                 (kerf.Recording, b"a\0b", "not the state of a pickled Recording")]
        for kind, state, expected in cases:
            with self.subTest(kind=kind, state=state), self.assertRaisesRegex(kerf.Error, expected):
                kind.__new__(kind).__setstate__(state)
        self.assertEqual(pickle.loads(pickle.dumps(kerf.Region(3, "a", "tooth", 100, 0.3))).E_MPa, 100)

    def test_texts_must_be_unicode(self):
        bone = small_block()
        start = kerf.pose((0, 0, 20))
        bad = "a\udcff"  # what os.fsdecode() makes of b"a\xff"
        calls = [
            lambda: kerf.Scene.parse(bad),
            lambda: kerf.Scene().with_value("bone.block", bad, 1),
            lambda: kerf.Region(1, bad, "cortical", 1000, 0.3),
            lambda: kerf.Region(1, "x", bad, 1000, 0.3),
            lambda: kerf.Region(1, "x", "cortical", 1000, 0.3, source=bad),
            lambda: kerf.Materials.parse(bad),
            lambda: kerf.Disc(**{bad: 3}),
            lambda: kerf.Simulation(bone, start, law=bad),
            lambda: kerf.Simulation(bone, start, effects=[bad]),
            lambda: kerf.HandSimulation(bone, start, undo_MB=16).checkpoint(bad),
            lambda: kerf.HandSimulation(bone, start, undo_MB=16).undo(bad),
            lambda: kerf.Bone.from_file("x.stl", mesh_units=bad),
        ]
        for i, call in enumerate(calls):
            with self.subTest(case=i), self.assertRaisesRegex(kerf.Error, r"^a text is not valid Unicode; it has '\\udcff' at position 1$"):
                call()
        with self.assertRaises(TypeError):
            kerf.Scene.parse(3)
        toml = "# \u00e4\n" + (ROOT / "examples/hello_cut.toml").read_text()
        self.assertEqual(kerf.Scene.parse(toml).toml, toml)

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
            self.assertEqual((inputs["set_down"].sum(), inputs["set_down"][0], inputs["dt_s"][0], inputs["rpm"][0]), (1, 1, 0, 0))
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
