// Steps that the imports of a CT, a surface and a mask share.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "bone/import/import.h"

namespace kerf {

inline constexpr double kRegionVoxel_mm = 0.2;

/// Times the stages of an import.
class Stages {
 public:
  explicit Stages(ImportReport& report) : report_(report) {}
  void Done(const std::string& name) {
    const auto now = Clock::now();
    report_.seconds.emplace_back(name, std::chrono::duration<double>(now - last_).count());
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  ImportReport& report_;
  Clock::time_point last_ = Clock::now();
};

/// Returns a function that reports the progress of one part as progress of the whole, from `from` to `to`.
std::function<void(double)> Part(const std::function<void(double)>& progress, double from, double to);

/// Returns the regions' materials: those of the options, or built-in ones. Throws kerf::Error if a region that is
/// needed is missing.
MaterialTable ChooseTable(const ImportOptions& options, bool use_atlas);

/// Keeps the largest piece if one was isolated; counts the others.
void DropDust(Bone& bone, bool one_piece, ImportReport& report);

/// Measures the bone, and notes in it what it was made from.
void Finish(const ImportOptions& options, Bone& bone, ImportReport& report);

ImportResult ImportCt(const std::string& path, const ImportOptions& options);
ImportResult ImportMesh(const std::string& path, const ImportOptions& options);
ImportResult ImportMask(const ImportOptions& options);

}  // namespace kerf
