// The settings of a case by the names of their knobs: ranges, words and values as texts.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/core/describe.h"
#include "experiment/study/knobs.h"
#include "session/scene/schema.h"

namespace kerf {

/// A visitor's walk over all settings, each under its knob's name.
template <typename V>
void Describe(StudySettings& p, V&& visit) {
  visit("voxel_mm", p.voxel_mm, Range{0.02, 4}, "edge of a voxel");
  visit("rim_samples_per_pitch", p.rim_samples_per_pitch, Range{1, 256}, "how finely the rim looks for bone");
  visit("substeps", p.substeps, Range{1, 64}, "steps in each tick, at least");
  visit("rate_hz", p.rate_hz, Range{250, 4000}, "ticks a second");
  visit("carve_interval_ticks", p.carve_interval_ticks, Range{1, 64}, "ticks between two removals of bone");
  visit("law", p.law, Choices{ForceLawWords()}, "force on a tooth");
  visit("material", p.material, Choices{{"regions", "uniform", "ct"}},
        "where E comes from; ct: of bones with CT numbers");
  visit("precision_bits", p.precision_bits, Range{4, 24}, "significand of the distances in the voxels");
  visit("method", p.method, Choices{{"voxel", "coarse", "slab"}}, "how the tick works");
  visit("heat_grid_mm", p.heat_grid_mm, Range{0, 2}, "cell of the heat grid, from 0.05 on; 0: no heat");
  visit("band_voxels", p.band_voxels, Range{2, 8}, "half width of the level set's band");
}

/// A number in its shortest form that reads back the same: "0.1", "1000".
std::string ShowNumber(double number);
/// The value of a setting as a text. Throws Error for a name that is no knob's.
std::string ValueOf(const StudySettings& settings, const std::string& knob);
/// Sets it from such a text. Throws Error for what is no value of it; ranges are the study file's matter.
void SetValue(StudySettings& settings, const std::string& knob, const std::string& value);
/// "voxel_mm=0.1 rim_samples_per_pitch=16 ...": all of them.
std::string ShowSettings(const StudySettings& settings);

/// FNV-1a: the same on every machine, for telling texts apart, not for security.
std::uint64_t HashText(std::string_view text);
/// 16 hexadecimal digits.
std::string ShowHash(std::uint64_t hash);

}  // namespace kerf
