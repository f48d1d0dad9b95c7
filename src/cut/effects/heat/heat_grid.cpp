#include "cut/effects/heat/heat_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace kerf {
namespace {

using heat::kSide;
using heat::Nodes;

constexpr float kSleepBelow_K = 0.1F;  // a block goes to sleep if no node is further above body temperature
constexpr double kEnoughBone = 0.5;    // fraction of bone around a point below which heat is spread further
constexpr double kMinBone = 0.02;      // fraction below which there is no bone
constexpr double kBoiling_C = 100, kSteam_mJ_per_mg = 2257;
constexpr double kBlood_J_per_m3K = 3.8e6;  // density and heat capacity of blood: 1050 kg/m3, 3617 J/kgK
constexpr double kLookCost = 4, kPutCost = 0.5, kSweepCost = 1;  // relative cost of a unit of work

int DivideDown(int a) {
  return a >> 3;  // by kSide, rounded down
}
int NodeOf(int x, int y, int z) {
  return ((x & 7) * kSide + (y & 7)) * kSide + (z & 7);
}
std::int64_t KeyOf(int x, int y, int z) {
  constexpr std::int64_t kMask = (1 << 21) - 1;
  return (x & kMask) << 42 | (y & kMask) << 21 | (z & kMask);
}
constexpr std::int64_t kNoKey = -1;

}  // namespace

HeatGrid::HeatGrid(const HeatGridParams& params, const BoneField& field)
    : params_(params), field_(field), inv_voxel_(1 / field.voxel_mm()) {
  const double H = params.spacing_mm;
  const double capacity = 1e-6 * params.density_kg_per_m3 * params.heat_capacity_J_per_kgK;  // mJ / (mm3 K)
  const double alpha = params.conductivity_W_per_mK / capacity;                              // mm2 / s
  cell_mJ_per_K_ = capacity * H * H * H;
  frame_s_ = std::min(params.longest_frame_s, H * H / (8 * alpha));
  conduction_ = static_cast<float>(alpha * frame_s_ / (H * H));
  const double perfusion_per_s =
      1e-6 / 60 * params.perfusion_mL_per_min_kg * params.density_kg_per_m3 * 1e-6 * kBlood_J_per_m3K / capacity;
  perfusion_factor_ = static_cast<float>(std::exp(-perfusion_per_s * frame_s_));
  const auto rate = [&](double h_W_per_m2K) {
    if (!(h_W_per_m2K > 0)) return 0.0F;
    const double U = 1e-3 / (1 / h_W_per_m2K + 0.5e-3 * H / params.conductivity_W_per_mK);  // mW / (mm2 K)
    return static_cast<float>(U * H * H * frame_s_ / cell_mJ_per_K_);
  };
  air_rate_ = rate(params.air_W_per_m2K);
  coolant_rate_ = rate(params.irrigation_W_per_m2K);
  boiling_K_ = static_cast<float>(kBoiling_C - params.body_C);
  water_K_ = static_cast<float>(kSteam_mJ_per_mg * params.water_mg_per_mm3 / capacity);
  const auto count = static_cast<std::size_t>(std::max(8.0, params.max_MB * 1e6 / sizeof(Block)));
  blocks_.resize(count);
  const std::size_t slots = std::bit_ceil(4 * count);
  keys_.assign(slots, kNoKey);
  numbers_.assign(slots, kNone);
  active_.reserve(count);
  looked_.reserve(count + 256);
  look_.reserve(count + 256);
  open_.reserve(6 * count);
  queue_.reserve(kMaxWaiting);
  figures_.peak_C = figures_.hottest_C = params.body_C;
}

std::size_t HeatGrid::CalcMemoryBytes() const {
  return blocks_.size() * (sizeof(Block) + 3 * sizeof(int) + 6 * sizeof(std::array<int, 2>)) +
         keys_.size() * (sizeof(std::int64_t) + sizeof(int)) + kMaxWaiting * sizeof(Waiting) + sizeof(*this);
}

// ---- blocks

std::size_t HeatGrid::FindSlot(const Index& index) const {
  const std::int64_t key = KeyOf(index.x, index.y, index.z);
  const std::size_t mask = keys_.size() - 1;
  std::size_t slot = (static_cast<std::uint64_t>(key) * 0x9E3779B97F4A7C15ULL >> 20) & mask;
  while (keys_[slot] != kNoKey && keys_[slot] != key) slot = (slot + 1) & mask;
  return slot;
}

int HeatGrid::Find(const Index& index) const {
  return numbers_[FindSlot(index)];
}

/// Computes the fraction of each cell that is bone; it can only decrease. Returns false if there is no bone at all.
bool HeatGrid::LookUpFractions(Block& block) {
  ++lookups_;
  const double H = params_.spacing_mm, h = field_.voxel_mm();
  const double band_mm = 0.999 * field_.band_mm();
  // For most nodes, phi of the nearest voxel, which is at most half a voxel's diagonal away, shows that their cells are
  // all bone or all air. The bound is a quarter larger, for distances with a gradient above 1.
  const double slack_mm = 1.25 * 0.5 * std::sqrt(3.0) * h;
  const auto bone_to_mm = static_cast<float>(-std::min(0.5 * H + slack_mm, band_mm));
  const auto air_from_mm = static_cast<float>(std::min(slack_mm, band_mm));
  const auto nearest = [&](int block_index, std::array<int, kSide>& voxels) {
    for (int i = 0; i < kSide; ++i) {
      voxels[static_cast<std::size_t>(i)] =
          static_cast<int>(std::floor(H * inv_voxel_ * (kSide * block_index + i) + 0.5));
    }
  };
  std::array<int, kSide> xs, ys, zs;
  nearest(block.index.x, xs);
  nearest(block.index.y, ys);
  nearest(block.index.z, zs);
  bool any = false;
  block.whole = true;
  std::size_t node = 0;
  for (int x = 0; x < kSide; ++x) {
    for (int y = 0; y < kSide; ++y) {
      const int vx = xs[static_cast<std::size_t>(x)], vy = ys[static_cast<std::size_t>(y)];
      const int in_layer = 64 * (vx & 7) + 8 * (vy & 7);
      int leaf_z = std::numeric_limits<int>::min();
      const float* leaf = nullptr;
      for (int z = 0; z < kSide; ++z, ++node) {
        float& fraction = block.fraction[node];
        if (fraction == 0) {
          block.whole = false;
          continue;
        }
        const int vz = zs[static_cast<std::size_t>(z)];
        if (vz >> 3 != leaf_z) {
          leaf_z = vz >> 3;
          leaf = field_.Read({vx >> 3, vy >> 3, leaf_z});
        }
        const float near_mm = leaf[in_layer + (vz & 7)];
        if (near_mm >= air_from_mm) {
          fraction = 0;
        } else if (near_mm > bone_to_mm) {
          const Vec3 p_F = H * Vec3(kSide * block.index.x + x, kSide * block.index.y + y, kSide * block.index.z + z);
          const double phi_mm = field_.Sample(p_F * inv_voxel_);
          auto bone = static_cast<float>(std::clamp(0.5 - phi_mm / H, 0.0, 1.0));
          if (std::abs(phi_mm) >= band_mm) bone = phi_mm < 0 ? 1 : 0;
          fraction = bone < heat::kMinFraction ? 0 : std::min(fraction, bone);
        }
        any = any || fraction > 0;
        block.whole = block.whole && fraction == 1;
      }
    }
  }
  return any;
}

/// Returns the block's number; kAir if it contains no bone, kNone if there is no room.
int HeatGrid::FindOrOpen(const Index& index) {
  const std::size_t slot = FindSlot(index);
  const bool known = keys_[slot] != kNoKey;
  if (known && numbers_[slot] != kNone) return numbers_[slot];  // kNone: bone may have been restored there
  if (used_ == blocks_.size()) {
    figures_.full = true;
    return kNone;
  }
  Block& block = blocks_[used_];
  block.index = index;
  block.fraction.fill(1);
  const bool bone = LookUpFractions(block);
  if (!bone && !known && 2 * taken_ > keys_.size()) return kAir;  // not stored, so that the table stays half empty
  if (!known) ++taken_;
  keys_[slot] = KeyOf(index.x, index.y, index.z);
  if (!bone) return numbers_[slot] = kAir;
  numbers_[slot] = static_cast<int>(used_++);
  block.looked_frame = frames_ + 1;
  Link(numbers_[slot]);
  Activate(numbers_[slot]);
  return numbers_[slot];
}

int HeatGrid::OpenNeighbour(int number, int face) {
  Block& block = blocks_[static_cast<std::size_t>(number)];
  Index at = block.index;
  (face < 2 ? at.x : face < 4 ? at.y : at.z) += face % 2 == 0 ? -1 : 1;
  return block.neighbours[static_cast<std::size_t>(face)] = FindOrOpen(at);
}

void HeatGrid::Link(int number) {
  Block& block = blocks_[static_cast<std::size_t>(number)];
  for (int face = 0; face < 6; ++face) {
    Index at = block.index;
    (face < 2 ? at.x : face < 4 ? at.y : at.z) += face % 2 == 0 ? -1 : 1;
    const int other = Find(at);
    block.neighbours[static_cast<std::size_t>(face)] = other;
    if (other >= 0) blocks_[static_cast<std::size_t>(other)].neighbours[static_cast<std::size_t>(face ^ 1)] = number;
  }
}

void HeatGrid::BoneRestored() {
  std::replace(numbers_.begin(), numbers_.end(), kAir, kNone);
  for (std::size_t i = 0; i < used_; ++i) {
    blocks_[i].grown = true;
    std::replace(blocks_[i].neighbours.begin(), blocks_[i].neighbours.end(), kAir, kNone);
  }
}

void HeatGrid::Activate(int number) {
  Block& block = blocks_[static_cast<std::size_t>(number)];
  if (block.active) return;
  block.active = true;
  active_.push_back(number);
}

/// Recomputes which part of the block is bone. Bone that was cut away took its heat with it.
void HeatGrid::Look(int number) {
  Block& block = blocks_[static_cast<std::size_t>(number)];
  if (block.looked_frame == frames_ + 1 && !block.grown) return;
  block.looked_frame = frames_ + 1;
  const Nodes before = block.fraction;
  if (std::exchange(block.grown, false)) block.fraction.fill(1);
  LookUpFractions(block);
  Nodes& theta = block.theta[static_cast<std::size_t>(now_)];
  for (std::size_t n = 0; n < kNodes; ++n) {
    const float lost = before[n] - block.fraction[n];
    if (lost < 0) theta[n] *= before[n] / block.fraction[n];
    if (!(lost > 0)) continue;
    const double mJ = cell_mJ_per_K_ * static_cast<double>(lost) * static_cast<double>(theta[n]);
    (mJ > 0 ? spent_.chips : spent_.chilled) += std::abs(mJ);
    if (block.fraction[n] == 0) theta[n] = 0;
  }
  Activate(number);
}

// ---- input of heat

bool HeatGrid::Put(const Vec3& p_F, const Vec3& else_F, double mJ) {
  if (!(mJ > 0 && std::isfinite(mJ)) || !IsInWorld(p_F) || !IsInWorld(else_F) || queue_.size() == kMaxWaiting)
    return false;
  queue_.push_back({p_F, else_F, mJ});
  spent_.put_in += mJ;
  return true;
}

/// Opens the neighbouring blocks of a node that receives heat, at each face of its block that the node lies on.
void HeatGrid::OpenBeside(int number, int x, int y, int z) {
  const Block& block = blocks_[static_cast<std::size_t>(number)];
  for (int face = 0; face < 6; ++face) {
    const int at = (face < 2 ? x : face < 4 ? y : z) & (kSide - 1);
    if (at != (face % 2 == 0 ? 0 : kSide - 1)) continue;
    int neighbour = block.neighbours[static_cast<std::size_t>(face)];
    if (neighbour == kNone) neighbour = OpenNeighbour(number, face);
    if (neighbour >= 0) Activate(neighbour);
  }
}

/// Spreads heat over the bone nodes that are less than `reach` (1 or 2) spacings from a point along each axis. Returns
/// false and does nothing if too little of their weight is bone.
bool HeatGrid::PutAt(const Vec3& p_F, double mJ, int reach) {
  const Vec3 q = p_F / params_.spacing_mm;
  const Vec3 low = glm::floor(q) + Vec3(1 - reach);
  struct Corner {
    Block* block;
    std::size_t node;
    double weight;
  };
  std::array<Corner, 64> corners;
  std::size_t count = 0;
  double sum = 0;
  const auto weigh = [&](double from) { return std::max(0.0, (1 - std::abs(from) / reach) / reach); };
  for (int i = 0; i < 8 * reach * reach * reach; ++i) {
    const Vec3 at = low + Vec3(i % (2 * reach), i / (2 * reach) % (2 * reach), i / (4 * reach * reach));
    const double weight = weigh(q.x - at.x) * weigh(q.y - at.y) * weigh(q.z - at.z);
    if (!(weight > 0)) continue;
    const int x = static_cast<int>(at.x), y = static_cast<int>(at.y), z = static_cast<int>(at.z);
    const int number = FindOrOpen({DivideDown(x), DivideDown(y), DivideDown(z)});
    if (number < 0) continue;
    Look(number);
    if (looked_.empty() || looked_.back() != number) looked_.push_back(number);
    Block& block = blocks_[static_cast<std::size_t>(number)];
    const auto node = static_cast<std::size_t>(NodeOf(x, y, z));
    if (block.fraction[node] == 0) continue;
    OpenBeside(number, x, y, z);
    sum += weight * static_cast<double>(block.fraction[node]);
    corners[count++] = {&block, node, weight};
  }
  if (sum < (reach == 1 ? kEnoughBone : kMinBone)) return false;
  // The temperature rise is proportional to the weight, independent of the fraction of bone.
  for (std::size_t i = 0; i < count; ++i) {
    float& theta = corners[i].block->theta[static_cast<std::size_t>(now_)][corners[i].node];
    theta += static_cast<float>(mJ * corners[i].weight / (sum * cell_mJ_per_K_));
    spent_.steam += Boil(*corners[i].block, corners[i].node, theta);
  }
  return true;
}

void HeatGrid::PutIn(Waiting& waiting) {
  const double mJ = waiting.mJ / ticks_frames_;
  waiting.mJ -= mJ;
  const std::size_t looked = looked_.size();
  const bool was_full = figures_.full;
  figures_.full = false;
  const bool put = PutAt(waiting.p_F, mJ, 1) || PutAt(waiting.p_F, mJ, 2) || PutAt(waiting.else_F, mJ, 2);
  if (!put) (figures_.full ? spent_.no_room : spent_.chips) += mJ;
  figures_.full = figures_.full || was_full;
  // Remove duplicates.
  for (std::size_t i = looked; i < looked_.size();) {
    const auto here = looked_.begin() + static_cast<std::ptrdiff_t>(i);
    if (std::find(looked_.begin(), here, *here) != here) {
      *here = looked_.back();
      looked_.pop_back();
    } else {
      ++i;
    }
  }
}

// ---- frames

void HeatGrid::Advance(double dt_s, const HeatWet& wet) {
  double left_s = dt_s;
  while (awake() && left_s > 0) {
    const double rest_s = frame_s_ - elapsed_s_;
    if (left_s < rest_s) {
      Work(left_s / rest_s, wet);
      elapsed_s_ += left_s;
      return;
    }
    left_s -= std::max(rest_s, 0.0);
    ticks_frames_ = 1 + std::floor(left_s / frame_s_);
    Work(1, wet);
    EndFrame();
  }
}

void HeatGrid::BeginFrame() {
  stage_ = Stage::kOpen;
  done_ = 0;
  put_ = queue_.size();
  std::swap(looked_, look_);
  looked_.clear();
  open_.clear();
  for (const int number : active_) {
    Block& block = blocks_[static_cast<std::size_t>(number)];
    for (int face = 0; face < 6; ++face) {
      if ((block.wanted >> face & 1) != 0) open_.push_back({number, face});
    }
    block.wanted = 0;
  }
}

double HeatGrid::CountWorkLeft() const {
  double left = 0;
  const auto add = [&](Stage stage, std::size_t count, double cost) {
    if (stage_ <= stage) left += cost * static_cast<double>(count - (stage_ == stage ? done_ : 0));
  };
  add(Stage::kOpen, open_.size(), kLookCost);
  add(Stage::kLook, look_.size(), kLookCost);
  add(Stage::kPut, put_, kPutCost);
  add(Stage::kSweep, active_.size(), kSweepCost);
  return left;
}

void HeatGrid::Work(double fraction_of_rest, const HeatWet& wet) {
  if (stage_ == Stage::kIdle) BeginFrame();
  if (fraction_of_rest >= 1) {
    while (WorkOne(wet) > 0) {
    }
    return;
  }
  double due = fraction_of_rest * CountWorkLeft();
  while (due > 0) {
    const double cost = WorkOne(wet);
    if (cost == 0) return;
    due -= cost;
  }
}

/// Does a unit of work. Returns its cost; 0 if none is left in the frame.
double HeatGrid::WorkOne(const HeatWet& wet) {
  const auto is_over = [&](Stage stage, std::size_t count) {
    if (stage_ != stage || done_ < count) return false;
    stage_ = static_cast<Stage>(static_cast<int>(stage) + 1);
    done_ = 0;
    return true;
  };
  is_over(Stage::kOpen, open_.size());
  is_over(Stage::kLook, look_.size());
  is_over(Stage::kPut, put_);
  switch (stage_) {
    case Stage::kOpen: {
      const auto [number, face] = open_[done_++];
      int neighbour = blocks_[static_cast<std::size_t>(number)].neighbours[static_cast<std::size_t>(face)];
      if (neighbour == kNone) neighbour = OpenNeighbour(number, face);
      if (neighbour >= 0) Activate(neighbour);
      return kLookCost;
    }
    case Stage::kLook:
      Look(look_[done_++]);
      return kLookCost;
    case Stage::kPut: {
      const unsigned lookups = lookups_;
      PutIn(queue_[done_++]);
      return kPutCost + kLookCost * (lookups_ - lookups);
    }
    case Stage::kSweep:
      if (done_ == active_.size()) return 0;
      Sweep(active_[done_++], wet);
      return kSweepCost;
    case Stage::kIdle:
      break;
  }
  return 0;
}

void HeatGrid::EndFrame() {
  stage_ = Stage::kIdle;
  elapsed_s_ = 0;
  ++frames_;
  now_ ^= 1;
  spent_.perfusion += frame_spent_.perfusion;
  spent_.irrigation += frame_spent_.irrigation;
  spent_.air += frame_spent_.air;
  spent_.steam += frame_spent_.steam;
  frame_spent_ = {};
  // The part of a long tick's heat that is for the following frames stays in the queue.
  if (ticks_frames_ == 1) queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(put_));
  float hottest_K = 0;
  std::size_t kept = 0;
  for (const int number : active_) {
    Block& block = blocks_[static_cast<std::size_t>(number)];
    hottest_K = std::max(hottest_K, block.hottest_K);
    if (block.hottest_K >= kSleepBelow_K || block.looked_frame == frames_) {
      active_[kept++] = number;
      continue;
    }
    block.active = false;
    block.wanted = 0;
    Nodes& theta = block.theta[static_cast<std::size_t>(now_)];
    double chilled = 0;
    for (std::size_t n = 0; n < kNodes; ++n) {
      chilled -= static_cast<double>(block.fraction[n]) * static_cast<double>(std::min(theta[n], 0.0F));
      theta[n] = std::max(theta[n], 0.0F);
    }
    spent_.rewarmed += cell_mJ_per_K_ * chilled;
    block.theta[static_cast<std::size_t>(now_ ^ 1)] = theta;
  }
  active_.resize(kept);
  figures_.hottest_C = params_.body_C + static_cast<double>(hottest_K);
  figures_.peak_C = std::max(figures_.peak_C, figures_.hottest_C);
}

// ---- results

HeatBalance HeatGrid::CalcBalance() const {
  HeatBalance balance = spent_;
  for (std::size_t i = 0; i < used_; ++i) {
    const Block& block = blocks_[i];
    for (std::size_t n = 0; n < kNodes; ++n) {
      const double mJ = cell_mJ_per_K_ * static_cast<double>(block.fraction[n]) *
                        static_cast<double>(block.theta[static_cast<std::size_t>(now_)][n]);
      (mJ > 0 ? balance.stored : balance.chilled) += std::abs(mJ);
    }
  }
  for (const Waiting& waiting : queue_) balance.waiting += waiting.mJ;
  return balance;
}

void HeatGrid::ForEachNode(const std::function<void(const HeatNode&)>& visit) const {
  for (std::size_t i = 0; i < used_; ++i) {
    const Block& block = blocks_[i];
    std::size_t n = 0;
    for (int x = 0; x < kSide; ++x) {
      for (int y = 0; y < kSide; ++y) {
        for (int z = 0; z < kSide; ++z, ++n) {
          if (block.fraction[n] == 0) continue;
          const Vec3 node(kSide * block.index.x + x, kSide * block.index.y + y, kSide * block.index.z + z);
          visit({params_.spacing_mm * node, static_cast<double>(block.fraction[n]),
                 params_.body_C + static_cast<double>(block.theta[static_cast<std::size_t>(now_)][n]),
                 static_cast<double>(block.above_47_s[n]), static_cast<double>(block.cem43_min[n])});
        }
      }
    }
  }
}

double HeatGrid::CurrentTheta(const HeatGrid& grid, const Block& block, int node) {
  return grid.params_.body_C +
         static_cast<double>(block.theta[static_cast<std::size_t>(grid.now_)][static_cast<std::size_t>(node)]);
}
double HeatGrid::Dose(const HeatGrid&, const Block& block, int node) {
  return static_cast<double>(block.cem43_min[static_cast<std::size_t>(node)]);
}

double HeatGrid::Interpolate(const Vec3& p_F, double (*value)(const HeatGrid&, const Block&, int), double none) const {
  if (!(field_.Sample(p_F * inv_voxel_) < 0)) return std::numeric_limits<double>::quiet_NaN();
  const Vec3 q = p_F / params_.spacing_mm;
  const Vec3 low = glm::floor(q);
  const Vec3 t = q - low;
  double sum = 0, weights = 0;
  for (int i = 0; i < 8; ++i) {
    const int x = static_cast<int>(low.x) + (i & 1), y = static_cast<int>(low.y) + (i >> 1 & 1),
              z = static_cast<int>(low.z) + (i >> 2);
    double weight = (i & 1 ? t.x : 1 - t.x) * (i & 2 ? t.y : 1 - t.y) * (i & 4 ? t.z : 1 - t.z);
    const int number = Find({DivideDown(x), DivideDown(y), DivideDown(z)});
    if (number == kAir) continue;
    double at = none;
    if (number >= 0) {
      const Block& block = blocks_[static_cast<std::size_t>(number)];
      weight *= static_cast<double>(block.fraction[static_cast<std::size_t>(NodeOf(x, y, z))]);
      at = value(*this, block, NodeOf(x, y, z));
    }
    sum += weight * at;
    weights += weight;
  }
  return weights > 0 ? sum / weights : none;
}

}  // namespace kerf
