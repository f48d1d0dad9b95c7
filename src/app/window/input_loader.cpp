#include "app/window/input_loader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>
#include <utility>

#include "app/window/is_ready.h"
#include "base/core/cancelled.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

// Faults of files that users meet often, for the translation. Without clauses that name an option.
[[maybe_unused]] constexpr std::array kFaults{
    Msg("{}: not an NRRD file despite its name"),
    Msg("{}: not a NIfTI file despite its name"),
    Msg("{}: not a MetaImage file despite its name"),
    Msg("{}: not a DICOM file despite its name"),
    Msg("{}: there is no such file or folder"),
    Msg("{}: no such file or folder"),
    Msg("{}: the folder is empty"),
    Msg("{}: unknown file type; kerf opens .toml, {}, .kerf-project, and folders of DICOM files"),
    Msg("{}: none of the {} files in the folder is a DICOM image"),
    Msg("{}: none of the {} files in the folder is a DICOM image; give the path of {}"),
    Msg("{}: no CT among the series: {}"),
    Msg("series {}: the modality is {}, not CT; kerf needs Hounsfield units"),
    Msg("series {}: 1 slice is not a volume; kerf needs at least 3"),
    Msg("series {}: {} slices are not a volume; kerf needs at least 3"),
    Msg("series {}: the slices are unequally spaced: {} mm between {} and {}, {} mm elsewhere; resample the scan "
        "evenly"),
    Msg("series {}: 1 slice is missing between {} and {} (at {} and {} mm; slices elsewhere are {} mm apart){}; what "
        "is missing belongs to the bone, so export the series again with all its slices"),
    Msg("series {}: {} slices are missing between {} and {} (at {} and {} mm; slices elsewhere are {} mm apart){}; "
        "what is missing belongs to the bone, so export the series again with all its slices"),
    Msg("{}: the DICOM header can't be read: {}; the file is damaged or cut off"),
    Msg("{}: the slice is cut off; its header states {} x {} pixels of {} bits, but not all are present"),
    Msg("{}: '{}' is encrypted; unpack the file with its password and give the folder"),
    Msg("the scan contains no bone: nothing above {} HU is larger than 1 cm3 (the brightest voxel has {} HU)"),
    Msg("{}: this is a label map, not a CT: its voxels have {} different values from {} to {}"),
    Msg("{}: the surface is not closed: {} of its edges belong to one triangle only, which is the rim of a hole or of "
        "a gap wider than {} mm; close the holes in a mesh program")};

/// Returns where the last option of the command line is named; npos: nowhere.
std::size_t FindOption(const std::string& line) {
  return std::max(line.rfind(" --") + 1, line.rfind("(--") + 1) - 1;  // npos + 1 is 0
}

/// Returns the line up to the clause that names an option.
std::string CutOptions(std::string line) {
  for (std::size_t option = FindOption(line); option != std::string::npos; option = FindOption(line)) {
    std::size_t clause = line.rfind("; ", option);
    if (clause == std::string::npos) clause = line.rfind(": ", option);
    if (clause == std::string::npos) break;
    line.resize(clause);
  }
  return line;
}

}  // namespace

std::string ExplainRefusal(const std::string& what) {
  constexpr std::string_view kWarning = "warning: ";
  std::string text;
  bool has_options = false;
  std::istringstream lines(what);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(kWarning)) line.erase(0, kWarning.size());
    const std::string shown = CutOptions(line);
    has_options = has_options || shown != line;
    text += (text.empty() ? "" : "\n") + TrMade(shown);
  }
  return has_options ? fmt::format("{}. {}", text, Tr("In a terminal, 'kerf import' has options for this.")) : text;
}

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
