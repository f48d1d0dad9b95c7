// Temperature of bone on a sparse grid: blocks of 8^3 nodes, opened where heat comes to, out of a pool set aside at the
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
  double max_MB = 16;  // of the pool
  double conductivity_W_per_mK = 0.32;
  double density_kg_per_m3 = 1908;
  double heat_capacity_J_per_kgK = 1313;
  double perfusion_mL_per_min_kg = 10;
  double body_C = 37;
  double air_W_per_m2K = 10;        // from a bare surface, which else loses nothing
  double irrigation_W_per_m2K = 0;  // where coolant runs; 0: none does
  double coolant_C = 21;
  double water_mg_per_mm3 = 0.2;  // of bone: boils off at 100 C; 0: none does
  double longest_frame_s = 0.2;
};

/// Where coolant runs: a short cylinder around the tool. Frame F of the bone's field.
struct HeatWet {
  Vec3 p_F{0};
  Vec3 axis_F{0, 0, 1};
  double radius_mm = 0;
  double half_mm = 0;  // along the axis
};

/// Since the start; of nodes that are bone.
struct HeatFigures {
  double peak_C = 0;         // highest temperature of a node ever
  double hottest_C = 0;      // of a node at the end of the last frame
  double above_47_s = 0;     // longest time of a node at 47 C and above
  double cem43_min = 0;      // greatest thermal dose of a node
  double past_47_mm3 = 0;    // of bone that was at 47 C and above for 1 min in all
  double past_dose_mm3 = 0;  // of bone with a dose above 16 min
  bool full = false;         // a block could not be opened
};

/// mJ. put_in + chilled + rewarmed = stored + waiting + perfusion + irrigation + air + steam + chips + no_room.
struct HeatBalance {
  double put_in = 0;
  double stored = 0;      // in bone that is warmer than the body
  double chilled = 0;     // that bone colder than the body lacks, or lacked when it was cut away: coolant took it
  double waiting = 0;     // for the next frame
  double rewarmed = 0;    // given to chilled bone where it fell asleep: it is as warm as the body again
  double perfusion = 0;   // carried off by blood
  double irrigation = 0;  // by coolant
  double air = 0;
  double steam = 0;
  double chips = 0;    // with bone that was cut away, or where there was none
  double no_room = 0;  // the pool was used up

  /// Where all has gone to, less where it comes from: 0 but for rounding.
  double CalcRest() const {
    return stored + waiting + perfusion + irrigation + air + steam + chips + no_room - put_in - chilled - rewarmed;
  }
};

/// A node, for drawing.
struct HeatNode {
  Vec3 p_F_mm;
  double share;  // of its cell that is bone, above 0
  double C;
  double above_47_s;
  double cem43_min;
};

/// Pennes' equation, rho c dT/dt = k lap T - w rho_b c_b (T - T_body) + source, in finite volumes: a cell of spacing^3
/// about each node, of which a share is bone (from phi at the node).
///
/// Model: heat goes between neighbours through the lesser of their shares; a surface loses heat to coolant or air
///        through h and half a cell in series; blocks that are not open are neighbours that no heat goes to, and are
///        opened before it comes. Cold opens none; a block that has nothing warm sleeps, and what coolant chilled in it
///        is taken to be as warm as the body again. At 100 C water boils off, whose heat goes with the steam.
/// Holds: second order in the spacing within the bone; no new extremes and an exact balance for any step; explicit, in
///        frames of at most spacing^2 / (8 alpha), whose blocks are worked off a few a tick.
/// What it takes from a node that is cut away goes with the chips.
class HeatGrid {
 public:
  /// The field must outlive the grid. Allocates; nothing else does.
  HeatGrid(const HeatGridParams& params, const BoneField& field);

  // ---- in the tick
  /// Heat at a point, or where there is no bone at another, mm and mJ; with no bone there either it goes with the
  /// chips. It goes in at the beginning of the next frame. False, and nothing done, when too much waits.
  bool Put(const Vec3& p_F, const Vec3& else_F, double mJ);
  /// How many times more something can be put in before the next frame.
  std::size_t room() const { return kMostWaiting - queue_.size(); }
  /// False: nothing is warm and nothing waits, Advance() does nothing.
  bool awake() const { return !active_.empty() || !queue_.empty(); }
  void Advance(double dt_s, const HeatWet& wet);
  /// There may be bone again where there was none. It is found where heat is put in, as warm as the body; what warmth
  /// and dose there are stay with the bone that was there all the time.
  void BoneCameBack();
  double frame_s() const { return frame_s_; }
  std::uint64_t frames() const { return frames_; }
  const HeatFigures& figures() const { return figures_; }

  // ---- any time, between ticks
  HeatBalance CalcBalance() const;
  void ForEachNode(const std::function<void(const HeatNode&)>& visit) const;
  /// C; that of the body where no block is open, NaN where there is no bone.
  double CalcTemperature(const Vec3& p_F) const { return Interpolate(p_F, &CurrentTheta, params_.body_C); }
  double CalcDose(const Vec3& p_F) const { return Interpolate(p_F, &Dose, 0); }
  const HeatGridParams& params() const { return params_; }
  std::size_t block_count() const { return used_; }
  std::size_t block_capacity() const { return blocks_.size(); }
  std::size_t CalcMemoryBytes() const;

 private:
  static constexpr std::size_t kNodes = heat::kNodes;
  static constexpr float kOpens_K = 0.2F;  // at a block's face, and the block beyond is opened
  static constexpr int kNone = -1;         // no block: not looked at, or no room for it
  static constexpr int kAir = -2;          // looked at: no bone in it
  static constexpr std::size_t kMostWaiting = 8192;

  struct Index {
    int x = 0, y = 0, z = 0;
    bool operator==(const Index&) const = default;
  };
  struct Block {
    std::array<heat::Nodes, 2> theta{};  // K above the body's; at the beginning and at the end of a frame
    heat::Nodes share{};                 // of the cell that is bone: 0, or half or more
    heat::Nodes above_47_s{};
    heat::Nodes cem43_min{};
    heat::Nodes boiled_K{};  // heat that boiled water off, by what it would have warmed the bone
    Index index;
    std::array<int, 6> neighbours{};  // -x, +x, -y, +y, -z, +z
    std::uint64_t looked_frame = 0;   // in which the shares were last looked up
    bool active = false;
    bool whole = false;   // all of it is bone
    bool grown = false;   // there may be more bone than its shares tell
    unsigned wanted = 0;  // neighbours that heat has come to
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
  bool LookUpShares(Block& block);
  void Look(int number);
  void PutIn(Waiting& waiting);
  bool PutAt(const Vec3& p_F, double mJ, int reach);
  void BeginFrame();
  double CountWorkLeft() const;
  void Work(double share_of_rest, const HeatWet& wet);
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
  float perfusion_keeps_;          // of the excess, in a frame
  float air_rate_, coolant_rate_;  // what a cell of bone with a whole face bare gives off in a frame, of its excess
  float boils_K_, water_K_;        // 100 C, and by how much a cell's water would warm it that boils off
  std::vector<Block> blocks_;
  std::size_t used_ = 0;
  std::vector<std::int64_t> keys_;  // of the table from index to block
  std::vector<int> numbers_;
  std::size_t taken_ = 0;
  std::vector<int> active_;  // in the order of opening
  std::vector<Waiting> queue_;
  std::vector<int> looked_, look_;  // blocks that heat was put into in this frame, and in the one before
  std::vector<std::array<int, 2>> open_;
  int now_ = 0;  // which theta is that of the frame's beginning
  std::uint64_t frames_ = 0;
  double elapsed_s_ = 0;  // of the frame
  double ticks_frames_ = 1;
  Stage stage_ = Stage::kIdle;
  unsigned lookups_ = 0;            // of the shares of a block
  std::size_t done_ = 0, put_ = 0;  // of the stage; of the queue at the frame's beginning
  HeatFigures figures_;
  HeatBalance spent_, frame_spent_;
};

}  // namespace kerf
