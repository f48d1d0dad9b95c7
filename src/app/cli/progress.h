// Progress bar on stderr with the remaining time; shown only on a terminal and only for work of more than two seconds.
#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "session/run/overall_progress.h"

namespace kerf::cli {

class ProgressBar {
 public:
  explicit ProgressBar(std::string title);
  ~ProgressBar();  // erases the bar
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Sets the text shown after the bar from the next Show() on. May be called by any thread.
  void SetNote(std::string note);
  /// Sets the text shown before the bar. May be called by any thread.
  void SetTitle(std::string title);
  /// Draws the bar. `fraction`: 0 to 1. May be called by any thread.
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

/// One bar for all the stages of a run. Not thread-safe.
class RunBar {
 public:
  explicit RunBar(std::vector<ExpectedStage> stages) : overall_(std::move(stages)) {}
  void Show(const std::string& stage, double fraction);
  /// As in StageBars.
  void SetNote(const std::string& note) { bar_.SetNote(note); }

 private:
  OverallProgress overall_;
  ProgressBar bar_{""};
  std::string stage_;
};

/// Consecutive bars for the named stages of one task. Not thread-safe.
class StageBars {
 public:
  void Show(const std::string& stage, double fraction);
  /// Sets the text shown after the bar of the current stage. It is removed together with that bar.
  void SetNote(const std::string& note);

 private:
  std::unique_ptr<ProgressBar> bar_;
  std::string stage_;
};

}  // namespace kerf::cli
