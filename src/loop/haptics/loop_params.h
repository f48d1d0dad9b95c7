// Parameters of the loop.
#pragma once

#include "kerf/describe.h"
#include "kerf/simulation.h"
#include "loop/haptics/governor.h"

namespace kerf {

/// Fault injection to demonstrate the governor: CPU time that each tick between two times wastes at full fidelity. At
/// coarse fidelity, half of it is wasted; at slab fidelity, a tenth.
struct InjectedLoad {
  double burn_us = 0;
  double from_s = 0;
  double to_s = 1e300;
};

struct LoopParams {
  double rate_hz = 1000;
  double watchdog_ms = 50;
  int leaves_per_tick = 4;
  int max_leaves_waiting = 1 << 15;  // others wait in the simulation
  int leaf_ring = 512;               // 2 kB each
  int sample_ring = 8192;
  int priority = 80;        // if the system permits it
  bool lock_memory = true;  // locks memory in RAM, if the system permits it
  GovernorParams governor;  // its period is set to the loop's
  InjectedLoad load;
};

inline constexpr Range kBurnRange_us{0, 1e5};

/// These are keys of [loop] of a scene too.
template <typename V>
void DescribeRate(double& rate_hz, V&& visit) {
  visit("rate_hz", rate_hz, kTickRateRange_hz, "ticks per second");
}
template <typename V>
void DescribeWatchdog(double& watchdog_ms, V&& visit) {
  visit("watchdog_ms", watchdog_ms, Range{2, 10000},
        "time since the start of a tick after which the watchdog sets the device's force to zero");
}
template <typename V>
void DescribeLeaves(const char* key, int& leaves_per_tick, V&& visit) {
  visit(key, leaves_per_tick, Range{0, 1000},
        "maximum number of changed leaves (blocks of 8 x 8 x 8 voxels) sent to the renderer per tick");
}
template <typename V>
void Describe(LoopParams& p, V&& visit) {
  DescribeRate(p.rate_hz, visit);
  DescribeGovernor(p.governor, visit);
  DescribeWatchdog(p.watchdog_ms, visit);
  DescribeLeaves("leaves_per_tick", p.leaves_per_tick, visit);
  visit("max_leaves_waiting", p.max_leaves_waiting, Range{1, 1 << 24}, "maximum number of leaves in the queue");
  visit("leaf_ring", p.leaf_ring, Range{1, 65536}, "capacity for leaves sent but not read yet");
  visit("sample_ring", p.sample_ring, Range{1, 1 << 20}, "capacity for samples logged but not read yet");
  visit("priority", p.priority, Range{0, 98}, "priority under SCHED_FIFO; 0: no real-time priority");
  visit("burn_us", p.load.burn_us, kBurnRange_us, "time to waste in each tick");
}

}  // namespace kerf
