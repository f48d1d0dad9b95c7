// Opening of a rehearsal's inputs in another thread.
#pragma once

#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "app/window/open_input.h"
#include "app/window/progress_meter.h"
#include "app/window/viewer_app.h"

namespace kerf {

/// Returns why an input cannot be opened, in the language of the window and without the options of the command line,
/// which the window does not have. `what`: message of the import; lines after the first one are warnings.
std::string ExplainRefusal(const std::string& what);

/// Opens at most one input at a time.
class InputLoader {
 public:
  explicit InputLoader(ViewerApp& viewer) : viewer_(viewer) {}
  /// Cancels, and waits for the work that is left.
  ~InputLoader();
  InputLoader(const InputLoader&) = delete;
  InputLoader& operator=(const InputLoader&) = delete;

  /// `input`: see OpenInput(). `shows`: the window shows the bone as soon as there is one; otherwise it goes on showing
  /// what it shows.
  void Begin(const std::string& input, const OpenOptions& options, bool shows);
  /// Ends the opening in progress; its work ends by itself.
  void Cancel();
  bool is_opening() const { return loading_ != nullptr; }
  /// Returns the input of the last Begin().
  const std::string& input() const { return input_; }
  /// Valid while is_opening().
  WorkProgress progress() const;
  /// Returns the CT of the input that is being opened, available as soon as it is read; null if there is none.
  std::shared_ptr<const Volume> ct() const;
  /// Returns the input once it is open, and nullopt until then. Throws Error if it cannot be opened.
  std::optional<OpenedInput> Take();
  /// Waits until no cancelled work is left, but not longer than `until`. Returns false if some is left.
  bool WaitUntil(std::chrono::steady_clock::time_point until) const;

 private:
  struct Loading {
    std::future<OpenedInput> opened;
    std::mutex mutex;  // protects everything below
    bool cancelled = false;
    bool shows = true;  // set at the beginning
    ProgressMeter progress;
    std::shared_ptr<const Volume> ct;
  };

  ViewerApp& viewer_;
  std::string input_;
  std::shared_ptr<Loading> loading_;
  std::vector<std::shared_ptr<Loading>> cancelled_;
};

}  // namespace kerf
