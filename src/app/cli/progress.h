// A progress bar on stderr with the time left; shown on a terminal only, and only for what takes more than two seconds.
#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <string>

namespace kerf::cli {

class ProgressBar {
 public:
  explicit ProgressBar(std::string title);
  ~ProgressBar();  // wipes the bar
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Stands behind the bar from the next Show() on. Any thread.
  void SetNote(std::string note);
  /// `fraction` 0 to 1. Any thread.
  void Show(double fraction);

 private:
  using Clock = std::chrono::steady_clock;
  std::mutex mutex_;
  std::string title_;
  std::string note_;
  bool terminal_;
  bool shown_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_{};
};

/// A bar for each stage of a work that tells its stages by name, one after the other. One thread.
class StageBars {
 public:
  void Show(const std::string& stage, double fraction);
  /// Behind the bar of the stage that is shown; gone with it.
  void SetNote(const std::string& note);

 private:
  std::unique_ptr<ProgressBar> bar_;
  std::string stage_;
};

}  // namespace kerf::cli
