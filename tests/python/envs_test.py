"""Tests of the tasks for policies, kerf.envs."""

import unittest

import numpy as np

import kerf
import kerf.envs


class Tasks(unittest.TestCase):
    def test_have_the_shape_of_gymnasiums_environments(self):
        for name in kerf.envs.TASKS:
            with self.subTest(task=name):
                task = kerf.envs.make(name)
                observation, info = task.reset(seed=3)
                self.assertIsInstance(info, dict)
                self.assertEqual(observation.dtype, task.observation_space.dtype)
                self.assertTrue(task.observation_space.contains(observation))
                task.action_space.seed(5)
                for _ in range(20):
                    action = task.action_space.sample()
                    self.assertTrue(task.action_space.contains(action))
                    observation, reward, terminated, truncated, info = task.step(action)
                    self.assertTrue(task.observation_space.contains(observation), observation)
                    self.assertIsInstance(reward, float)
                    self.assertIsInstance(terminated, bool)
                    self.assertIsInstance(truncated, bool)
                    if terminated or truncated:
                        break
                self.assertIs(task.unwrapped, task)
                task.close()

    def test_same_seed_and_actions_give_the_same_bits(self):
        for name in kerf.envs.TASKS:
            with self.subTest(task=name):
                outcomes = []
                for _ in range(2):
                    task = kerf.envs.make(name)
                    observations = [task.reset(seed=7)[0]]
                    for _ in range(60):
                        observations.append(task.step(task.baseline(observations[-1]))[0])
                    outcomes.append((np.array(observations), task.bone.hash()))
                np.testing.assert_array_equal(outcomes[0][0], outcomes[1][0])
                self.assertEqual(outcomes[0][1], outcomes[1][1])
                self.assertFalse(np.array_equal(kerf.envs.make(name).reset(seed=8)[0], outcomes[0][0][0]))

    def test_baselines_do_what_the_task_asks(self):
        for seed in range(4):
            with self.subTest(seed=seed):
                _, info = kerf.envs.play(kerf.envs.DepthControl(), seed=seed)
                self.assertLess(info["depth_error_mm"], 0.1)  # the baseline waits until the error is below 0.1 mm
                task = kerf.envs.StraightOsteotomy()
                _, info = kerf.envs.play(task, seed=seed)
                self.assertLess(info["aside_mm"], 0.3)
                self.assertEqual(len(task.bone.pieces(1)), 2)  # the bar is cut through
                total, info = kerf.envs.play(kerf.envs.StayOffNerve(), seed=seed)
                self.assertEqual(info["canal_cut_mm3"], 0)
                self.assertGreater(info["left_mm"], 1)
                self.assertLess(info["left_mm"], 2)

    def test_poor_policies_score_less(self):
        down = np.array([0, 0, -1.0])
        total, info = kerf.envs.play(kerf.envs.StayOffNerve(), lambda _: down, seed=1)
        self.assertGreater(info["canal_cut_mm3"], 0)
        self.assertLess(total, kerf.envs.play(kerf.envs.StayOffNerve(), seed=1)[0] - 20)
        aside = np.array([0, 0.05, -0.3])
        self.assertLess(kerf.envs.play(kerf.envs.StraightOsteotomy(), lambda _: aside, seed=1)[0],
                        kerf.envs.play(kerf.envs.StraightOsteotomy(), seed=1)[0])
        shallow = lambda seen: np.array([0.5, 0, 1 if seen[6] > 0.5 else -1])  # noqa: E731
        self.assertLess(kerf.envs.play(kerf.envs.DepthControl(), shallow, seed=1)[0],
                        kerf.envs.play(kerf.envs.DepthControl(), seed=1)[0])

    def test_an_episode_without_an_end_is_truncated(self):
        task = kerf.envs.DepthControl()
        task.reset(seed=1)
        steps = 0
        truncated = False
        while not truncated:
            _, _, terminated, truncated, _ = task.step((0, 0, 0))
            steps += 1
            self.assertFalse(terminated)
        self.assertEqual(steps, task.LIMIT_S / (task.STEP_TICKS * task.TICK_S))

    def test_mistakes_are_errors(self):
        for voxel_mm in (9, "a", float("nan")):
            with self.assertRaisesRegex(kerf.Error, "voxel_mm = .* valid range"):
                kerf.envs.DepthControl(voxel_mm)
        with self.assertRaisesRegex(kerf.Error, "reset"):
            kerf.envs.DepthControl().step((0, 0, 0))
        with self.assertRaisesRegex(kerf.Error, "depth_control"):
            kerf.envs.make("cut")
        task = kerf.envs.StayOffNerve()
        task.reset(seed=1)
        while not task.step((0, 0, -1))[2]:
            pass
        with self.assertRaisesRegex(kerf.Error, "has ended"):
            task.step((0, 0, 0))
        task = kerf.envs.DepthControl()
        task.reset()
        with self.assertRaisesRegex(kerf.Error, "3 finite numbers"):
            task.step((0, float("nan"), 0))


if __name__ == "__main__":
    unittest.main()
