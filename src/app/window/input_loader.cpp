#include "app/window/input_loader.h"

#include <algorithm>
#include <array>
#include <utility>

#include "app/window/is_ready.h"
#include "base/core/cancelled.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

// Faults of files that users meet often, for the translation.
[[maybe_unused]] constexpr std::array kFaults{Msg("{}: not an NRRD file despite its name"),
                                              Msg("{}: there is no such file or folder"),
                                              Msg("{}: no such file or folder")};

}  // namespace

InputLoader::~InputLoader() {
  Cancel();
}

void InputLoader::Begin(const std::string& input, const OpenOptions& options, bool shows) {
  auto loading = std::make_shared<Loading>();
  loading->shows = shows;
  loading->progress.Set("opening", 0, ProgressMeter::Now_s());
  OpenWatcher watcher;
  Loading* const at = loading.get();  // outlives its thread
  watcher.progress = [at](const std::string& stage, double fraction) {
    const std::lock_guard lock(at->mutex);
    if (at->cancelled) throw Cancelled();
    at->progress.Set(stage, fraction, ProgressMeter::Now_s());
  };
  watcher.bone = [this, at](std::shared_ptr<const Bone> bone, bool final) {
    const std::lock_guard lock(at->mutex);
    if (at->cancelled) throw Cancelled();
    if (at->shows) viewer_.bone().Show(std::move(bone), final);
  };
  watcher.ct = [at](std::shared_ptr<const Volume> ct) {
    const std::lock_guard lock(at->mutex);
    at->ct = std::move(ct);
  };
  loading->opened =
      std::async(std::launch::async, [input, options, watcher] { return OpenInput(input, options, watcher); });
  input_ = input;
  loading_ = std::move(loading);
  viewer_.trace().Write("opening", {{"input", input_}});
}

void InputLoader::Cancel() {
  if (!loading_) return;
  {
    const std::lock_guard lock(loading_->mutex);
    loading_->cancelled = true;
  }
  cancelled_.push_back(std::exchange(loading_, nullptr));
  viewer_.trace().Write("cancelled", {{"input", input_}});
}

WorkProgress InputLoader::progress() const {
  const std::lock_guard lock(loading_->mutex);
  return loading_->progress.Get(ProgressMeter::Now_s());
}

std::shared_ptr<const Volume> InputLoader::ct() const {
  if (!loading_) return nullptr;
  const std::lock_guard lock(loading_->mutex);
  return loading_->ct;
}

std::optional<OpenedInput> InputLoader::Take() {
  std::erase_if(cancelled_, [](const std::shared_ptr<Loading>& loading) { return IsReady(loading->opened); });
  if (!loading_ || !IsReady(loading_->opened)) return std::nullopt;
  const std::shared_ptr<Loading> loaded = std::exchange(loading_, nullptr);
  OpenedInput opened = loaded->opened.get();
  opened.bone_was_shown = opened.bone_was_shown && loaded->shows;
  return opened;
}

bool InputLoader::WaitUntil(std::chrono::steady_clock::time_point until) const {
  return std::all_of(cancelled_.begin(), cancelled_.end(), [&](const std::shared_ptr<Loading>& loading) {
    return loading->opened.wait_until(until) == std::future_status::ready;
  });
}

}  // namespace kerf
