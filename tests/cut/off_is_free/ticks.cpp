// Ticks without effects, whose instructions tools/off_is_free counts: a tool on a path and a hand-held tool, in bone
// and in air. Each kind has its own function, so that callgrind distinguishes them. Prints the heap use as JSON.
#include <fmt/format.h>

#include <atomic>
#include <cstdlib>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>
#include <memory>
#include <new>
#include <utility>

#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "kerf/coupled.h"
#include "kerf/simulation.h"

namespace {

std::atomic<std::size_t> allocations{0};
std::atomic<std::size_t> bytes{0};

void* Allocate(std::size_t size, std::size_t alignment) {
  allocations += 1;
  bytes += size;
  // aligned_alloc() requires a multiple of the alignment.
  void* memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) {
  return Allocate(size, __STDCPP_DEFAULT_NEW_ALIGNMENT__);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return Allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

// libhwy times its clock when it is loaded, with an instruction that valgrind lacks on some processors. Its result is
// used by libhwy's own benchmarks only; this definition replaces the library's.
namespace hwy::platform {
double TimerResolution();
double TimerResolution() {
  return 1e-9;
}
}  // namespace hwy::platform

namespace kerf {
namespace {

constexpr int kTicks = 60;
constexpr double kStep_mm = 0.005;  // per tick: 5 mm/s
constexpr double kAir_mm = 5;

Bone MakeBone() {
  BlockParams block;
  block.size_mm = {8, 4, 4};
  block.voxel_mm = 0.2;
  return MakeBlock(block, DefaultMandibleTable());
}

/// Returns the pose of an upright disc in the plane y = 0, with its rim `below_mm` below the block's upper face.
Pose DiscPose(double below_mm) {
  return {glm::angleAxis(-glm::half_pi<double>(), Vec3{1, 0, 0}), {0, 0, 0.5 * DiscSaw{}.diameter_mm - below_mm}};
}

struct HeapUse {
  std::size_t allocations, bytes;
};
template <typename Call>
HeapUse CountHeap(const Call& call) {
  const HeapUse before{allocations, bytes};
  call();
  return {allocations - before.allocations, bytes - before.bytes};
}

}  // namespace

// Not in an anonymous namespace and not inlined: these names appear in callgrind's output.
[[gnu::noinline]] void LedCut(Simulation& simulation) {
  for (int i = 1; i <= kTicks; ++i) simulation.Tick({DiscPose(1 + kStep_mm * i), 0.001, 7500});
}
[[gnu::noinline]] void LedAir(Simulation& simulation) {
  for (int i = 1; i <= kTicks; ++i) simulation.Tick({DiscPose(-kAir_mm + kStep_mm * i), 0.001, 7500});
}
[[gnu::noinline]] void HeldCut(CoupledSimulation& simulation) {
  for (int i = 1; i <= kTicks; ++i) simulation.Tick({.X_WH = DiscPose(1 + kStep_mm * i)});
}
[[gnu::noinline]] void HeldAir(CoupledSimulation& simulation) {
  for (int i = 1; i <= kTicks; ++i) simulation.Tick({.X_WH = DiscPose(-kAir_mm + kStep_mm * i)});
}

namespace {

void RunAll() {
  SimulationParams led_params;
  led_params.effects.clear();
  const CoupledParams held_params{led_params};
  Bone led_bone = MakeBone();
  Bone held_bone = MakeBone();

  std::unique_ptr<Simulation> led;
  std::unique_ptr<CoupledSimulation> held;
  const HeapUse setup = CountHeap([&] {
    led = std::make_unique<Simulation>(std::move(led_bone), led_params, DiscPose(-kAir_mm));
    held = std::make_unique<CoupledSimulation>(std::move(held_bone), held_params, DiscPose(-kAir_mm));
  });
  const HeapUse ticks = CountHeap([&] {
    LedAir(*led);
    HeldAir(*held);
    led->SetDown(DiscPose(1));
    held->SetDown(DiscPose(1));
    LedCut(*led);
    HeldCut(*held);
  });
  fmt::print("{{\"ticks\": {}, \"setup\": [{}, {}], \"heap_in_ticks\": [{}, {}]}}\n", kTicks, setup.allocations,
             setup.bytes, ticks.allocations, ticks.bytes);
}

}  // namespace
}  // namespace kerf

int main() {
  kerf::RunAll();
  return 0;
}
