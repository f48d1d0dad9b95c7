#include "app/window/ct_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "app/window/import_notes.h"
#include "app/window/is_ready.h"
#include "base/core/cancelled.h"
#include "bone/import/hu_check.h"
#include "bone/import/import.h"
#include "bone/import/padding.h"
#include "bone/import/patient_frame.h"
#include "kerf/error.h"
#include "view/ui/translate.h"

namespace kerf {

Volume ReadCtOf(const Bone& bone, const std::string& path, const std::function<void(double)>& progress) {
  const auto fail = [&path](const char* text) { return Error(fmt::format(fmt::runtime(text), path)); };
  std::error_code error;
  // Anything else, such as a pipe, could block for ever.
  if (!std::filesystem::is_directory(path, error) && !std::filesystem::is_regular_file(path, error)) {
    throw fail(Msg("The CT is no longer at {}, so the slices show it only near the bone."));
  }
  ImportOptions options;
  options.series = GetNote(bone, "import_series_uid");
  options.as_ct = true;  // as was confirmed
  options.frame = GetNote(bone, "import_frame").substr(0, 3);
  options.spacing_z_mm = std::strtod(GetNote(bone, "import_spacing_z_mm").c_str(), nullptr);
  options.progress = progress;
  ImportReport report;
  Volume ct;
  try {
    ct = StoreAlongPatient(ReadCt(path, options, report));
  } catch (const Cancelled&) {
    throw;
  } catch (const std::exception&) {  // also if memory is insufficient
    throw fail(Msg("The CT in {} could not be read again, so the slices show it only near the bone."));
  }
  if (fmt::format("{:016x}", CalcHash(ct)) != GetNote(bone, "import_input_hash")) {
    throw fail(Msg("The CT in {} has changed since the bone was made, so the slices show it only near the bone."));
  }
  ClearPadding(ct);
  TakeAsHu(ct, std::strtod(GetNote(bone, "import_iso_HU").c_str(), nullptr), false, path);
  return ct;
}

void CtReader::Begin(std::shared_ptr<const Bone> bone, const std::string& path) {
  Cancel();
  cancelled_ = std::make_shared<std::atomic<bool>>(false);
  reading_ = std::async(std::launch::async, [bone = std::move(bone), path, cancelled = cancelled_]() -> Result {
    const auto progress = [&cancelled](double) {
      if (*cancelled) throw Cancelled();
    };
    try {
      return {std::make_shared<const Volume>(ReadCtOf(*bone, path, progress)), ""};
    } catch (const std::exception& e) {
      return {nullptr, e.what()};
    }
  });
}

void CtReader::Cancel() {
  if (!reading_.valid()) return;
  *cancelled_ = true;
  unused_.push_back(std::move(reading_));
}

std::optional<CtReader::Result> CtReader::Take() {
  std::erase_if(unused_, [](const std::future<Result>& reading) { return IsReady(reading); });
  if (!IsReady(reading_)) return std::nullopt;
  return reading_.get();
}

bool CtReader::WaitUntil(std::chrono::steady_clock::time_point until) const {
  const auto ends = [until](const std::future<Result>& reading) {
    return !reading.valid() || reading.wait_until(until) == std::future_status::ready;
  };
  return ends(reading_) && std::all_of(unused_.begin(), unused_.end(), ends);
}

}  // namespace kerf
