#include "session/run/force_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/files/disk_space.h"
#include "kerf/error.h"
#include "session/run/effect_record.h"

namespace kerf {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 18;

}  // namespace

std::string FormatForceHeader(const std::string& effects) {
  std::string line =
      "time_s,skipped,handle_x_mm,handle_y_mm,handle_z_mm,tool_x_mm,tool_y_mm,tool_z_mm,hand_x_N,hand_y_N,hand_z_N,"
      "device_x_N,device_y_N,device_z_N,cut_N,face_N,friction_N,thrust_sum_N,engaged_teeth,removed_mm3,tick_us,late_us,"
      "fidelity,status";
  line += effects;
  line += '\n';
  return line;
}

void AppendForceRow(const LoopRow& r, const std::string& effects, std::string& csv) {
  fmt::format_to(std::back_inserter(csv),
                 "{:.6f},{},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},"
                 "{:.6g},{:.6g},{:.6g},{:.6g},{:.5g},{:.6g},{:.1f},{:.1f},{},{}",
                 r.time_s, r.skipped, r.p_WC_mm.x, r.p_WC_mm.y, r.p_WC_mm.z, r.p_WT_mm.x, r.p_WT_mm.y, r.p_WT_mm.z,
                 r.f_hand_N.x, r.f_hand_N.y, r.f_hand_N.z, r.f_device_N.x, r.f_device_N.y, r.f_device_N.z, r.cut_N,
                 r.face_N, r.friction_N, r.thrust_N, r.engaged_teeth, r.removed_mm3, r.tick_us, r.late_us,
                 kerf::ToString(r.fidelity), r.status);
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
