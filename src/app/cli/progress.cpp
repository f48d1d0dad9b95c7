#include "app/cli/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace kerf::cli {
namespace {

int CountColumns() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace

ProgressBar::ProgressBar(std::string title) : title_(std::move(title)), terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  if (shown_) std::fputs("\r\x1b[K", stderr);
}

void ProgressBar::SetNote(std::string note) {
  const std::lock_guard lock(mutex_);
  note_ = std::move(note);
}

void ProgressBar::SetTitle(std::string title) {
  const std::lock_guard lock(mutex_);
  title_ = std::move(title);
}

void ProgressBar::Show(double fraction) {
  if (!terminal_) return;
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = Clock::now();
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  fraction = std::clamp(fraction, 0.0, 1.0);
  const bool long_enough = elapsed_s > 0.5 && (shown_ || elapsed_s / std::max(fraction, 0.01) > 2);
  if (!long_enough || now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  shown_ = true;
  // A line that wraps could not be drawn again in place.
  constexpr int kWidth = 30;
  constexpr int kOther = 30;  // columns for the percentage and the time left
  const int width = std::clamp(CountColumns() - static_cast<int>(title_.size() + note_.size()) - kOther, 5, kWidth);
  const int filled = static_cast<int>(fraction * width + 0.5);
  const std::string left =
      fraction > 0.05 ? fmt::format("{:.0f} s left", elapsed_s * (1 - fraction) / fraction) : std::string("...");
  fmt::print(stderr, "\r\x1b[K{} [{:#>{}}{:.>{}}] {:3.0f} %  {}  {}", title_, "", filled, "", width - filled,
             100 * fraction, left, note_);
  std::fflush(stderr);
}

void RunBar::Show(const std::string& stage, double fraction) {
  if (stage != stage_) {
    bar_.SetTitle(stage);
    bar_.SetNote("");
    stage_ = stage;
  }
  bar_.Show(overall_.Advance(stage, fraction));
}

void StageBars::Show(const std::string& stage, double fraction) {
  if (stage != stage_) {
    bar_.reset();  // erases this bar before the next one is drawn
    bar_ = std::make_unique<ProgressBar>(stage);
    stage_ = stage;
  }
  bar_->Show(fraction);
}

void StageBars::SetNote(const std::string& note) {
  if (bar_) bar_->SetNote(note);
}

}  // namespace kerf::cli
