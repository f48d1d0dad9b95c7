// Log of events in the window, one line of JSON each, for tests that control the window from outside, and for studies.
#pragma once

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace kerf {

/// Writes complete lines one at a time. Does nothing without a file.
class Trace {
 public:
  /// `path`: empty for no file. Throws Error if the file cannot be written.
  explicit Trace(const std::string& path);

  /// Writes `event` with `details` and the number of seconds since the beginning.
  void Write(const std::string& event, nlohmann::json details = nlohmann::json::object());
  /// Writes the state at most ten times per second if it differs from the previous one, otherwise twice, so that a test
  /// can wait for a time in which nothing changes.
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
