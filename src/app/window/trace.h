// What happens in the window, a line of JSON each: for tests that drive it from outside, and for studies.
#pragma once

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace kerf {

/// Written line by line, each whole. Does nothing when it has no file.
class Trace {
 public:
  /// Empty: none. Throws Error when it can't be written.
  explicit Trace(const std::string& path);

  /// `event` with the seconds since the beginning, and whatever else.
  void Write(const std::string& event, nlohmann::json details = nlohmann::json::object());
  /// The state, when it differs from the one before; at most ten a second.
  void WriteState(nlohmann::json state);
  explicit operator bool() const { return file_.is_open(); }

 private:
  double Now_s() const;

  std::ofstream file_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  nlohmann::json state_;
  double written_s_ = -1;
};

}  // namespace kerf
