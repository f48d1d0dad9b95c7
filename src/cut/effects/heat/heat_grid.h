// Temperature of bone on a sparse grid: blocks of 8^3 nodes, opened where heat arrives, from a pool allocated at the
// start.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "bone/grid/field.h"
#include "cut/effects/heat/kernels.h"
#include "kerf/geometry.h"

namespace kerf {

struct HeatGridParams {
  double spacing_mm = 0.4;
  double max_MB = 16;  // size of the pool
  double conductivity_W_per_mK = 0.32;
  double density_kg_per_m3 = 1908;
  double heat_capacity_J_per_kgK = 1313;
  double perfusion_mL_per_min_kg = 10;
  double body_C = 37;
  double air_W_per_m2K = 10;        // heat transfer from a bare surface without coolant
  double irrigation_W_per_m2K = 0;  // heat transfer from a bare surface with coolant; 0: no coolant
  double coolant_C = 21;
  double water_mg_per_mm3 = 0.2;  // water in bone, which boils off at 100 C; 0: none
  double longest_frame_s = 0.2;
};

/// Region with coolant: a short cylinder around the tool. Frame F of the bone's field.
struct HeatWet {
  Vec3 p_F{0};
  Vec3 axis_F{0, 0, 1};
  double radius_mm = 0;
  double half_mm = 0;  // along the axis
};

/// Values since the start, over nodes that are bone.
struct HeatFigures {
  double peak_C = 0;         // highest temperature of a node so far
  double hottest_C = 0;      // highest temperature at the end of the last frame
  double above_47_s = 0;     // longest time of a node at 47 C or above
  double cem43_min = 0;      // largest thermal dose of a node
  double past_47_mm3 = 0;    // bone that was at 47 C or above for at least 1 min in total
  double past_dose_mm3 = 0;  // bone with a dose above 16 min
  bool full = false;         // a block could not be opened
};

/// Heat balance, mJ: put_in + chilled + rewarmed = stored + waiting + perfusion + irrigation + air + steam + chips +
/// no_room.
struct HeatBalance {
  double put_in = 0;
  double stored = 0;      // in bone that is warmer than the body
  double chilled = 0;     // heat deficit of bone colder than the body, including bone cut away: due to coolant
  double waiting = 0;     // heat that waits for the next frame
  double rewarmed = 0;    // given to chilled bone in blocks that went to sleep, which are reset to body temperature
  double perfusion = 0;   // carried off by blood
  double irrigation = 0;  // carried off by coolant
  double air = 0;
  double steam = 0;
  double chips = 0;    // heat in bone that was cut away, or put in where there was no bone
  double no_room = 0;  // lost because the pool was used up

  /// Returns the sum of outputs less inputs: 0 except for rounding.
  double CalcRest() const {
    return stored + waiting + perfusion + irrigation + air + steam + chips + no_room - put_in - chilled - rewarmed;
  }
};

/// Node, for drawing.
struct HeatNode {
  Vec3 p_F_mm;
  double fraction;  // fraction of its cell that is bone, above 0
  double C;
  double above_47_s;
  double cem43_min;
};

/// Temperature of bone by Pennes' equation, rho c dT/dt = k lap T - w rho_b c_b (T - T_body) + source, in finite
/// volumes: a cell of spacing^3 about each node, a fraction of which is bone (from phi at the node).
///
/// Model: heat flows between neighbours through the smaller of their fractions. A surface loses heat to coolant or air
/// through the heat transfer coefficient and half a cell in series. No heat flows to blocks that are not open; blocks
/// are opened before heat reaches them. Blocks are not opened for cold. A block without warm nodes sleeps, and any
/// chilled bone in it is reset to body temperature. Water boils off at 100 C, and its heat leaves with the steam. Bone
/// that is cut away takes its heat with it.
///
/// Properties: the error within the bone is of second order in the spacing. For any step, no new extremes arise and the
/// heat balance is exact. The scheme is explicit, in frames of at most spacing^2 / (8 alpha); each tick computes a few
/// blocks of a frame.
class HeatGrid {
 public:
  /// The field must outlive the grid. Allocates; no other function does.
  HeatGrid(const HeatGridParams& params, const BoneField& field);

  // ---- in the tick
  /// Puts heat in at `p_F` or, if there is no bone there, at `else_F`; mm and mJ. If there is no bone there either, the
  /// heat leaves with the chips. Heat enters at the beginning of the next frame. Returns false and does nothing if
  /// too much heat is waiting.
  bool Put(const Vec3& p_F, const Vec3& else_F, double mJ);
  /// Number of further calls of Put() that are possible before the next frame.
  std::size_t room() const { return kMaxWaiting - queue_.size(); }
  /// Returns false if nothing is warm and nothing is waiting: then Advance() does nothing.
  bool awake() const { return !active_.empty() || !queue_.empty(); }
  void Advance(double dt_s, const HeatWet& wet);
  /// Must be called after bone has been restored. The restored bone is found when heat is next put in, and starts at
  /// body temperature. Temperature and dose of the other bone are unchanged.
  void BoneRestored();
  double frame_s() const { return frame_s_; }
  std::uint64_t frames() const { return frames_; }
  const HeatFigures& figures() const { return figures_; }

  // ---- at any time between ticks
  HeatBalance CalcBalance() const;
  void ForEachNode(const std::function<void(const HeatNode&)>& visit) const;
  /// Returns the temperature, C; body temperature where no block is open, NaN where there is no bone.
  double CalcTemperature(const Vec3& p_F) const { return Interpolate(p_F, &CurrentTheta, params_.body_C); }
  double CalcDose(const Vec3& p_F) const { return Interpolate(p_F, &Dose, 0); }
  const HeatGridParams& params() const { return params_; }
  std::size_t block_count() const { return used_; }
  std::size_t block_capacity() const { return blocks_.size(); }
  std::size_t CalcMemoryBytes() const;

 private:
  static constexpr std::size_t kNodes = heat::kNodes;
  static constexpr float kOpenAbove_K = 0.2F;  // excess at a block's face at which the block beyond it is opened
  static constexpr int kNone = -1;             // no block: not tested, or no room for it
  static constexpr int kAir = -2;              // tested: contains no bone
  static constexpr std::size_t kMaxWaiting = 8192;

  struct Index {
    int x = 0, y = 0, z = 0;
    bool operator==(const Index&) const = default;
  };
  struct Block {
    std::array<heat::Nodes, 2> theta{};  // K above body temperature, at the beginning and at the end of a frame
    heat::Nodes fraction{};              // fraction of each cell that is bone: 0, or at least half
    heat::Nodes above_47_s{};
    heat::Nodes cem43_min{};
    heat::Nodes boiled_K{};  // heat that boiled off water, as the temperature rise that it would have caused
    Index index;
    std::array<int, 6> neighbours{};  // -x, +x, -y, +y, -z, +z
    std::uint64_t looked_frame = 0;   // frame in which the fractions were last computed
    bool active = false;
    bool whole = false;   // all of it is bone
    bool grown = false;   // there may be more bone than its fractions indicate
    unsigned wanted = 0;  // bits of the neighbours that heat has reached
    float hottest_K = 0;  // at the end of the last frame
    double past_47_mm3 = 0, past_dose_mm3 = 0;
  };
  struct Waiting {
    Vec3 p_F;
    Vec3 else_F;
    double mJ;
  };
  struct Padded;
  enum class Stage { kIdle, kOpen, kLook, kPut, kSweep };

  static double CurrentTheta(const HeatGrid& grid, const Block& block, int node);
  static double Dose(const HeatGrid&, const Block& block, int node);
  double Interpolate(const Vec3& p_F, double (*value)(const HeatGrid&, const Block&, int), double none) const;

  std::size_t FindSlot(const Index& index) const;
  int Find(const Index& index) const;
  int FindOrOpen(const Index& index);
  int OpenNeighbour(int number, int face);
  void OpenBeside(int number, int x, int y, int z);
  void Link(int number);
  void Activate(int number);
  bool LookUpFractions(Block& block);
  void Look(int number);
  void PutIn(Waiting& waiting);
  bool PutAt(const Vec3& p_F, double mJ, int reach);
  void BeginFrame();
  double CountWorkLeft() const;
  void Work(double fraction_of_rest, const HeatWet& wet);
  double WorkOne(const HeatWet& wet);
  void EndFrame();
  void Sweep(int number, const HeatWet& wet);
  void Pad(const Block& block, Padded& padded) const;
  void Cool(const Block& block, const Padded& padded, const HeatWet& wet, heat::Nodes& theta);
  void Count(Block& block, const heat::Nodes& before, const heat::Nodes& after);
  double Boil(Block& block, std::size_t node, float& theta) const;

  HeatGridParams params_;
  const BoneField& field_;
  double inv_voxel_;
  double cell_mJ_per_K_;           // of a cell that is all bone
  double frame_s_;                 // length of a frame
  float conduction_;               // alpha frame / spacing^2
  float perfusion_factor_;         // fraction of the excess that remains after a frame
  float air_rate_, coolant_rate_;  // loss of a cell with one bare face in a frame, relative to its excess
  float boiling_K_, water_K_;      // 100 C above body temperature; the rise that would boil off a cell's water
  std::vector<Block> blocks_;
  std::size_t used_ = 0;
  std::vector<std::int64_t> keys_;  // hash table from index to block
  std::vector<int> numbers_;
  std::size_t taken_ = 0;
  std::vector<int> active_;  // in the order of opening
  std::vector<Waiting> queue_;
  std::vector<int> looked_, look_;  // blocks into which heat was put in this frame, and in the previous one
  std::vector<std::array<int, 2>> open_;
  int now_ = 0;  // index of the theta at the beginning of the frame
  std::uint64_t frames_ = 0;
  double elapsed_s_ = 0;     // time since the start of the frame
  double ticks_frames_ = 1;  // frames over which the heat of a long tick is spread
  Stage stage_ = Stage::kIdle;
  unsigned lookups_ = 0;            // computations of a block's fractions
  std::size_t done_ = 0, put_ = 0;  // work done in the stage; entries in the queue when the frame began
  HeatFigures figures_;
  HeatBalance spent_, frame_spent_;
};

}  // namespace kerf
