#include "session/run/force_log.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/files/disk_space.h"
#include "kerf/error.h"
#include "session/run/effect_record.h"

namespace kerf {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 18;

}  // namespace

const Columns<LoopRow>& LoopColumns() {
  const char* const kTool = "magnitude of the force on the tool from edge, flats and friction";
  static const Columns<LoopRow> kColumns = JoinColumns<LoopRow>(
      {{{"time_s", "{:.6f}", "deadline of the tick since the start", &LoopRow::time_s},
        {"skipped", "{}", "number of deadlines missed before it", &LoopRow::skipped}},
       PartsOf<LoopRow>("handle_{}_mm", "xyz", "{:.5f}", "coupling point, as reported by the device",
                        &LoopRow::p_WC_mm),
       PartsOf<LoopRow>("tool_{}_mm", "xyz", "{:.5f}", "origin of the tool frame", &LoopRow::p_WT_mm),
       PartsOf<LoopRow>("hand_{}_N", "xyz", "{:.6g}", "force on the hand in the simulation", &LoopRow::f_hand_N),
       PartsOf<LoopRow>("device_{}_N", "xyz", "{:.6g}", "force requested from the device", &LoopRow::f_device_N),
       {{"cut_N", "{:.6g}", kTool, &LoopRow::cut_N},
        {"face_N", "{:.6g}", kTool, &LoopRow::face_N},
        {"friction_N", "{:.6g}", kTool, &LoopRow::friction_N},
        {"thrust_sum_N", "{:.6g}", "as in `kerf run`", &LoopRow::thrust_N},
        {"engaged_teeth", "{:.5g}", "as in `kerf run`", &LoopRow::engaged_teeth},
        {"removed_mm3", "{:.6g}", "volume removed since the previous row, by occupancy of voxels",
         &LoopRow::removed_mm3},
        {"tick_us", "{:.1f}", "duration of the tick, without logging and sending", &LoopRow::tick_us},
        {"late_us", "{:.1f}", "lateness of its start", &LoopRow::late_us},
        {"fidelity", "{}", "full, coarse or slab", [](const LoopRow& row) { return kerf::ToString(row.fidelity); }},
        {"status", "{}", "sum of the bits below", &LoopRow::status}}});
  return kColumns;
}

LoopRow MakeLoopRow(const LoopTick& tick, const Vec3& p_TC_mm, double removed_mm3) {
  const CoupledOutput& out = tick.coupled;
  LoopRow row;
  row.time_s = tick.time_s;
  row.skipped = tick.in.skipped;
  row.p_WC_mm = tick.X_WH.Point(p_TC_mm);
  row.p_WT_mm = out.X_WT.p_AB;
  row.f_hand_N = out.f_H_W_N;
  row.f_device_N = tick.force.f_H_W_N;
  row.cut_N = static_cast<float>(glm::length(out.f_cut_W_N));
  row.face_N = static_cast<float>(glm::length(out.f_face_W_N));
  row.friction_N = static_cast<float>(glm::length(out.f_friction_W_N));
  row.thrust_N = static_cast<float>(out.thrust_sum_N);
  row.engaged_teeth = static_cast<float>(out.engaged_teeth);
  row.removed_mm3 = static_cast<float>(removed_mm3);
  row.tick_us = tick.tick_us;
  row.late_us = tick.late_us;
  row.fidelity = out.fidelity;
  row.status = out.status;
  return row;
}

std::string FormatForceHeader(const std::string& effects) {
  return CsvHeader(LoopColumns()) + effects + "\n";
}

void AppendForceRow(const LoopRow& row, const std::string& effects, std::string& csv) {
  AppendCsv(LoopColumns(), row, csv);
  csv += effects;
  csv += '\n';
}

ForcePoint ForcePoint::Merge(const ForcePoint& a, const ForcePoint& b) {
  return {a.time_s, std::max(a.device_N, b.device_N), std::max(a.hand_N, b.hand_N)};
}

ForcePoint MakeForcePoint(const LoopRow& row) {
  return {row.time_s, glm::length(row.f_device_N), glm::length(row.f_hand_N)};
}

ForceLog::ForceLog(const std::string& path, const std::string& effects, double keep_free_bytes)
    : path_(path), file_(path), keep_free_bytes_(keep_free_bytes) {
  waiting_ = FormatForceHeader(effects);
  waiting_.reserve(kBlockBytes + 1024);
}

void ForceLog::Take(const LoopRow& row, std::span<const double> channels) {
  if (!failure_.empty()) return;
  AppendForceRow(row, FormatEffectRow(channels), waiting_);
  if (waiting_.size() >= kBlockBytes) Write();
}

void ForceLog::Write() {
  try {
    if (keep_free_bytes_ > 0 && ReadFreeDiskBytes(path_) < keep_free_bytes_ + static_cast<double>(waiting_.size())) {
      throw Error(fmt::format("{}: can't be written: the last {:.1f} MB of the disk are reserved for the recording",
                              path_, 1e-6 * keep_free_bytes_));
    }
    file_->Append(waiting_);
  } catch (const Error& e) {
    failure_ = e.what();
    file_.reset();
  }
  waiting_.clear();
}

void ForceLog::Commit() {
  if (failure_.empty()) Write();
  if (!failure_.empty()) throw Error(failure_);
  file_->Commit();
}

}  // namespace kerf
