#include "loop/record/step.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cmath>

#include "base/compress/bytes.h"
#include "device/devices/lattice.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::size_t kComponents = 7;
enum PoseMode : std::uint8_t { kLattice = 0, kRaw = 1 };

// ---- Columns.

/// Run-length encoding: pairs of a value and its number of repetitions.
template <typename Get>
void PutRuns(ByteWriter& out, const std::vector<RecordedStep>& steps, Get&& get) {
  for (std::size_t i = 0; i < steps.size();) {
    const std::uint64_t value = get(steps[i]);
    std::size_t end = i + 1;
    while (end < steps.size() && get(steps[end]) == value) ++end;
    out.PutNumber(value);
    out.PutNumber(end - i);
    i = end;
  }
}

template <typename Set>
void GetRuns(ByteReader& in, std::vector<RecordedStep>& steps, Set&& set) {
  for (std::size_t i = 0; i < steps.size();) {
    const std::uint64_t value = in.GetNumber();
    const std::uint64_t count = in.GetNumber();
    if (count == 0 || count > steps.size() - i) throw Error("has a run that extends past its steps");
    for (const std::size_t end = i + static_cast<std::size_t>(count); i < end; ++i) set(steps[i], value);
  }
}

/// Stores each integer as its difference from the linear extrapolation of the two previous ones.
void PutSecondDifferences(ByteWriter& out, const std::vector<std::int64_t>& values) {
  std::uint64_t before = 0;
  std::uint64_t before_that = 0;
  for (const std::int64_t value : values) {
    const auto now = static_cast<std::uint64_t>(value);
    out.PutSigned(static_cast<std::int64_t>(now - 2 * before + before_that));
    before_that = before;
    before = now;
  }
}

void GetSecondDifferences(ByteReader& in, std::vector<std::int64_t>& values) {
  std::uint64_t before = 0;
  std::uint64_t before_that = 0;
  for (std::int64_t& value : values) {
    const std::uint64_t now = static_cast<std::uint64_t>(in.GetSigned()) + 2 * before - before_that;
    value = static_cast<std::int64_t>(now);
    before_that = before;
    before = now;
  }
}

/// Maps doubles to integers one to one, preserving their order.
std::uint64_t ToOrdered(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  return bits >> 63 != 0 ? ~bits : bits | (std::uint64_t{1} << 63);
}
double FromOrdered(std::uint64_t ordered) {
  return std::bit_cast<double>(ordered >> 63 != 0 ? ordered ^ (std::uint64_t{1} << 63) : ~ordered);
}

/// Extrapolates doubles from the previous ones with a polynomial of the given degree. Bit-identical on all platforms.
class Extrapolator {
 public:
  explicit Extrapolator(int degree) : degree_(degree) {}
  double Next() const {
    double guess = a_;
    if (degree_ == 1) guess = a_ + (a_ - b_);
    if (degree_ == 2) guess = (a_ - b_) + (a_ - b_) + (a_ - b_) + c_;
    return std::isfinite(guess) ? guess : 0;
  }
  void Add(double x) {
    c_ = b_;
    b_ = a_;
    a_ = x;
  }

 private:
  int degree_;
  double a_ = 0, b_ = 0, c_ = 0;
};

std::array<double, kComponents> Components(const Pose& X) {
  return {X.p_AB.x, X.p_AB.y, X.p_AB.z, X.R_AB.w, X.R_AB.x, X.R_AB.y, X.R_AB.z};
}

void PutRawPoses(ByteWriter& out, const std::vector<RecordedStep>& steps) {
  for (std::size_t c = 0; c < kComponents; ++c) {
    std::string best;
    for (int degree = 0; degree < 3; ++degree) {
      ByteWriter column;
      column.Put(static_cast<std::uint8_t>(degree));
      Extrapolator extrapolator(degree);
      for (const RecordedStep& step : steps) {
        const double x = Components(step.X)[c];
        column.PutSigned(static_cast<std::int64_t>(ToOrdered(x) - ToOrdered(extrapolator.Next())));
        extrapolator.Add(x);
      }
      if (best.empty() || column.bytes().size() < best.size()) best = column.Take();
    }
    out.PutText(best);
  }
}

void GetRawPoses(ByteReader& in, std::vector<RecordedStep>& steps) {
  for (std::size_t c = 0; c < kComponents; ++c) {
    ByteReader column(in.GetText());
    const auto degree = column.Get<std::uint8_t>();
    if (degree > 2) throw Error("has a column of an unknown kind");
    Extrapolator extrapolator(degree);
    for (RecordedStep& step : steps) {
      const double x = FromOrdered(ToOrdered(extrapolator.Next()) + static_cast<std::uint64_t>(column.GetSigned()));
      extrapolator.Add(x);
      Pose& X = step.X;
      const std::array<double*, kComponents> to{&X.p_AB.x, &X.p_AB.y, &X.p_AB.z, &X.R_AB.w,
                                                &X.R_AB.x, &X.R_AB.y, &X.R_AB.z};
      *to[c] = x;
    }
  }
}

std::vector<LatticePose> FindAllOnLattice(const std::vector<RecordedStep>& steps) {
  std::vector<LatticePose> found;
  for (const RecordedStep& step : steps) {
    const std::optional<LatticePose> lattice = FindOnLattice(step.X);
    if (!lattice) return {};
    found.push_back(*lattice);
  }
  return found;
}

void PutLatticePoses(ByteWriter& out, const std::vector<LatticePose>& poses) {
  std::vector<std::int64_t> column(poses.size());
  for (std::size_t c = 0; c < 6; ++c) {
    for (std::size_t i = 0; i < poses.size(); ++i) column[i] = c < 3 ? poses[i].p[c] : poses[i].q[c - 3];
    PutSecondDifferences(out, column);
  }
  for (const LatticePose& pose : poses) {
    out.Put(static_cast<std::uint8_t>(2 * pose.largest + (pose.negative ? 1 : 0)));
  }
}

void GetLatticePoses(ByteReader& in, std::vector<RecordedStep>& steps) {
  std::vector<LatticePose> poses(steps.size());
  std::vector<std::int64_t> column(steps.size());
  for (std::size_t c = 0; c < 6; ++c) {
    GetSecondDifferences(in, column);
    for (std::size_t i = 0; i < poses.size(); ++i) (c < 3 ? poses[i].p[c] : poses[i].q[c - 3]) = column[i];
  }
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto kind = in.Get<std::uint8_t>();
    if (kind > 7) throw Error("has a pose of an unknown kind");
    poses[i].largest = kind / 2;
    poses[i].negative = kind % 2 != 0;
    steps[i].X = MakePose(poses[i]);
  }
}

// ---- States and hashes.

struct StateColumn {
  const char* name;  // column name in `kerf log --csv`
  double (*get)(const RecordedState&);
  void (*set)(RecordedState&, double);
  double unit;
};
const std::array<StateColumn, 9> kStateColumns{{
    {"time_s", [](const RecordedState& s) { return s.time_s; }, [](RecordedState& s, double x) { s.time_s = x; }, 1e-6},
    {"tool_x_mm", [](const RecordedState& s) { return s.p_WT_mm.x; },
     [](RecordedState& s, double x) { s.p_WT_mm.x = x; }, 1e-3},
    {"tool_y_mm", [](const RecordedState& s) { return s.p_WT_mm.y; },
     [](RecordedState& s, double x) { s.p_WT_mm.y = x; }, 1e-3},
    {"tool_z_mm", [](const RecordedState& s) { return s.p_WT_mm.z; },
     [](RecordedState& s, double x) { s.p_WT_mm.z = x; }, 1e-3},
    {"force_x_N", [](const RecordedState& s) { return s.f_N.x; }, [](RecordedState& s, double x) { s.f_N.x = x; },
     1e-3},
    {"force_y_N", [](const RecordedState& s) { return s.f_N.y; }, [](RecordedState& s, double x) { s.f_N.y = x; },
     1e-3},
    {"force_z_N", [](const RecordedState& s) { return s.f_N.z; }, [](RecordedState& s, double x) { s.f_N.z = x; },
     1e-3},
    {"removed_total_mm3", [](const RecordedState& s) { return s.removed_mm3; },
     [](RecordedState& s, double x) { s.removed_mm3 = x; }, 1e-3},
    {"engaged_teeth", [](const RecordedState& s) { return s.engaged_teeth; },
     [](RecordedState& s, double x) { s.engaged_teeth = x; }, 1e-3},
}};

// Whole numbers of units up to this one survive the conversion to double and back.
constexpr std::int64_t kLargestUnits = std::int64_t{1} << 48;

std::int64_t Round(double x, double unit) {
  const double units = x / unit;
  return std::abs(units) < static_cast<double>(kLargestUnits) ? std::llround(units) : 0;
}

void PutStates(ByteWriter& out, const RecordedBlock& block) {
  out.PutNumber(block.states.size());
  for (const RecordedState& state : block.states) out.PutNumber(state.step - block.first_step);
  std::vector<std::int64_t> column(block.states.size());
  for (const StateColumn& c : kStateColumns) {
    for (std::size_t i = 0; i < column.size(); ++i) column[i] = Round(c.get(block.states[i]), c.unit);
    PutSecondDifferences(out, column);
  }
}

std::uint64_t GetStepWithin(ByteReader& in, const RecordedBlock& block) {
  const std::uint64_t at = in.GetNumber();
  if (at >= block.steps.size()) throw Error("refers to a step that it does not have");
  return block.first_step + at;
}

void GetStates(ByteReader& in, RecordedBlock& block) {
  const std::size_t count = in.GetCount(kStateColumns.size());
  if (count > block.steps.size()) throw Error("has more states than steps");
  block.states.resize(count);
  for (RecordedState& state : block.states) state.step = GetStepWithin(in, block);
  std::vector<std::int64_t> column(block.states.size());
  for (const StateColumn& c : kStateColumns) {
    GetSecondDifferences(in, column);
    for (const std::int64_t value : column) {
      if (value > kLargestUnits || value < -kLargestUnits) throw Error("has an impossible state");
    }
    for (std::size_t i = 0; i < column.size(); ++i) c.set(block.states[i], static_cast<double>(column[i]) * c.unit);
  }
}

}  // namespace

std::string DescribeDifference(const RecordedState& recorded, const RecordedState& now) {
  for (const StateColumn& c : kStateColumns) {
    const std::int64_t before = Round(c.get(recorded), c.unit);
    const std::int64_t after = Round(c.get(now), c.unit);
    if (before == after) continue;
    return fmt::format("{} was recorded as {:.6g} and is replayed as {:.6g}", c.name,
                       static_cast<double>(before) * c.unit, static_cast<double>(after) * c.unit);
  }
  return "";
}

std::string EncodeBlock(const RecordedBlock& block) {
  ByteWriter out;
  out.PutNumber(block.first_step);
  out.Put(block.first_time_s);
  out.PutNumber(block.steps.size());
  const std::vector<RecordedStep>& steps = block.steps;
  const std::vector<LatticePose> lattice = FindAllOnLattice(steps);
  const bool raw = lattice.size() != steps.size();
  out.Put(static_cast<std::uint8_t>(raw ? kRaw : kLattice));
  if (raw) {
    PutRawPoses(out, steps);
  } else {
    PutLatticePoses(out, lattice);
  }
  PutRuns(out, steps, [](const RecordedStep& s) { return std::uint64_t{s.flags}; });
  PutRuns(out, steps, [](const RecordedStep& s) { return std::uint64_t{s.buttons}; });
  PutRuns(out, steps, [](const RecordedStep& s) { return std::uint64_t{s.fidelity}; });
  PutRuns(out, steps, [](const RecordedStep& s) { return std::uint64_t{s.piece}; });
  PutRuns(out, steps, [](const RecordedStep& s) { return std::uint64_t{s.checkpoint}; });
  PutRuns(out, steps, [](const RecordedStep& s) { return std::bit_cast<std::uint64_t>(s.dt_s); });
  PutRuns(out, steps, [](const RecordedStep& s) { return std::uint64_t{s.skipped}; });
  PutRuns(out, steps, [](const RecordedStep& s) { return std::bit_cast<std::uint64_t>(s.rpm); });
  // Low and high bytes are stored separately: if only the low bytes are used, the high bytes compress to almost
  // nothing.
  for (const int shift : {0, 8}) {
    for (const RecordedStep& s : steps) out.Put(static_cast<std::uint8_t>(s.force_check >> shift));
    for (const RecordedStep& s : steps) out.Put(static_cast<std::uint8_t>(s.bone_check >> shift));
  }
  PutStates(out, block);
  out.PutNumber(block.hashes.size());
  for (const RecordedHash& hash : block.hashes) {
    out.PutNumber(hash.step - block.first_step);
    out.Put(hash.force);
    out.Put(hash.bone);
  }
  return out.Take();
}

RecordedBlock DecodeBlock(std::string_view bytes) {
  ByteReader in(bytes);
  RecordedBlock block;
  block.first_step = in.GetNumber();
  block.first_time_s = in.Get<double>();
  const std::uint64_t count = in.GetNumber();
  if (count > kMaxStepsInBlock) throw Error("states more steps than a block can hold");
  block.steps.resize(static_cast<std::size_t>(count));
  std::vector<RecordedStep>& steps = block.steps;
  const auto mode = in.Get<std::uint8_t>();
  if (mode == kRaw) {
    GetRawPoses(in, steps);
  } else if (mode == kLattice) {
    GetLatticePoses(in, steps);
  } else {
    throw Error("has poses of an unknown kind");
  }
  GetRuns(in, steps, [](RecordedStep& s, std::uint64_t x) {
    if ((x & ~std::uint64_t{kRecordedFlags}) != 0) throw Error("has flags that this version does not support");
    s.flags = static_cast<std::uint32_t>(x);
  });
  GetRuns(in, steps, [](RecordedStep& s, std::uint64_t x) { s.buttons = static_cast<std::uint32_t>(x); });
  GetRuns(in, steps, [](RecordedStep& s, std::uint64_t x) {
    if (x > 2) throw Error("has a fidelity that this version does not support");
    s.fidelity = static_cast<std::uint8_t>(x);
  });
  GetRuns(in, steps, [](RecordedStep& s, std::uint64_t x) { s.piece = static_cast<std::uint32_t>(x); });
  GetRuns(in, steps, [](RecordedStep& s, std::uint64_t x) { s.checkpoint = static_cast<std::uint32_t>(x); });
  GetRuns(in, steps, [](RecordedStep& s, std::uint64_t x) { s.dt_s = std::bit_cast<double>(x); });
  GetRuns(in, steps, [](RecordedStep& s, std::uint64_t x) { s.skipped = static_cast<std::uint32_t>(x); });
  GetRuns(in, steps, [](RecordedStep& s, std::uint64_t x) { s.rpm = std::bit_cast<double>(x); });
  for (const int shift : {0, 8}) {
    const auto get = [&] { return static_cast<std::uint16_t>(in.Get<std::uint8_t>() << shift); };
    for (RecordedStep& s : steps) s.force_check = static_cast<std::uint16_t>(s.force_check | get());
    for (RecordedStep& s : steps) s.bone_check = static_cast<std::uint16_t>(s.bone_check | get());
  }
  GetStates(in, block);
  const std::size_t hashes = in.GetCount(17);
  if (hashes > block.steps.size()) throw Error("has more hashes than steps");
  block.hashes.resize(hashes);
  for (RecordedHash& hash : block.hashes) {
    hash.step = GetStepWithin(in, block);
    hash.force = in.Get<std::uint64_t>();
    hash.bone = in.Get<std::uint64_t>();
  }
  if (in.left() != 0) throw Error("is longer than its content");
  return block;
}

}  // namespace kerf
