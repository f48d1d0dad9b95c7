# %% [markdown]
# # A policy that learns to keep a depth
#
# `kerf.envs` has three tasks in the shape of Gymnasium's environments. In `DepthControl`, a saw held by a spring cuts a
# groove of a given depth. Here a policy with three numbers learns it by a search without gradients: the cross-entropy
# method, which draws policies, keeps the best, and draws the next ones around them.

# %%
import matplotlib.pyplot as plt
import numpy as np

import kerf
import kerf.envs

task = kerf.envs.DepthControl()
print("actions:", task.action_space)
print("observations:", task.observation_space)

# %% [markdown]
# The policy reads the depth that is wanted (number 7) and the depth that there is (number 6). It moves down in proportion
# to their difference, and along while that difference is below a tolerance.


# %%
def make_policy(numbers):
    gain, tolerance_mm, speed = np.exp(numbers)

    def policy(observation):
        error_mm = observation[7] - observation[6]
        along = min(speed, 1) if abs(error_mm) < tolerance_mm else 0
        return np.array([along, 0, -np.clip(gain * error_mm, -1, 1)])

    return policy


def rate(numbers, seeds):
    return float(np.mean([kerf.envs.play(task, make_policy(numbers), seed=seed)[0] for seed in seeds]))


random = np.random.default_rng(1)
mean, spread = np.log([0.3, 1.0, 0.2]), np.full(3, 1.0)
history = []
for generation in range(6):
    policies = mean + spread * random.normal(size=(8, 3))
    rewards = np.array([rate(p, seeds=(2 * generation, 2 * generation + 1)) for p in policies])
    best = policies[np.argsort(rewards)[-3:]]
    mean, spread = best.mean(axis=0), 0.5 * spread + 0.5 * best.std(axis=0)
    history.append(rewards)
    print(f"generation {generation + 1}: reward of the best {rewards.max():.2f}, of all {rewards.mean():.2f}")

# %%
unseen = range(100, 106)
untrained = rate(np.log([0.3, 1.0, 0.2]), unseen)
learned = rate(mean, unseen)
scripted = float(np.mean([kerf.envs.play(task, seed=seed)[0] for seed in unseen]))
print("gain, tolerance (mm), speed:", np.round(np.exp(mean), 3))
print(f"reward on six episodes that it has not seen: before {untrained:.2f}, learned {learned:.2f}, scripted baseline {scripted:.2f}")

figure, axes = plt.subplots(figsize=(7, 3.5))
for generation, rewards in enumerate(history, 1):
    axes.plot([generation] * len(rewards), rewards, "o", color="tab:blue", alpha=0.5)
axes.plot(range(1, len(history) + 1), [r.max() for r in history], color="tab:blue", label="best of the generation")
axes.axhline(scripted, linestyle="--", color="tab:orange", label="scripted baseline, unseen episodes")
axes.set_xlabel("generation")
axes.set_ylabel("reward of a policy (0 is best)")
axes.legend()
figure.tight_layout()
