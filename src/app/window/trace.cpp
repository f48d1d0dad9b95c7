#include "app/window/trace.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "base/files/files.h"
#include "kerf/error.h"

namespace kerf {

Trace::Trace(const std::string& path) {
  if (path.empty()) return;
  CheckWritable(path);
  file_.open(path, std::ios::trunc);
  if (!file_) throw Error(fmt::format("{}: can't be written", path));
}

double Trace::Now_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
}

void Trace::Write(const std::string& event, nlohmann::json details) {
  if (!file_.is_open()) return;
  details["event"] = event;
  details["time_s"] = std::round(1e3 * Now_s()) / 1e3;
  file_ << details.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n' << std::flush;
}

void Trace::WriteState(nlohmann::json state) {
  constexpr double kChanged_s = 0.1;
  constexpr double kSame_s = 0.5;
  if (!file_.is_open() || Now_s() < written_s_ + (state == state_ ? kSame_s : kChanged_s)) return;
  written_s_ = Now_s();
  state_ = state;
  Write("state", std::move(state));
}

}  // namespace kerf
