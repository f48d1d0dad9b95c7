// Access to the settings of a case by the names of their knobs: ranges, choices and values as text.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "experiment/study/knobs.h"
#include "kerf/describe.h"
#include "session/scene/schema.h"

namespace kerf {

/// Calls a visitor for each setting, with the name of its knob.
template <typename V>
void Describe(StudySettings& p, V&& visit) {
  visit("voxel_mm", p.voxel_mm, kVoxelRange_mm, "edge of a voxel");
  DescribeSampling(p, visit);
  DescribeRate(p.rate_hz, visit);
  DescribeCarving(p, visit);
  visit("law", p.law, Choices{ForceLawWords()}, "force on a tooth");
  visit("material", p.material, Choices{{"regions", "uniform", "ct"}}, "source of E; ct: for bones with CT numbers");
  visit("precision_bits", p.precision_bits, kPrecisionRange_bits, "significand of the distances in the voxels");
  visit("method", p.method, Choices{{"voxel", "coarse", "slab"}}, "method of the tick");
  visit("heat_grid_mm", p.heat_grid_mm, Range{0, 2}, "cell of the heat grid, at least 0.05; 0: no heat");
  visit("band_voxels", p.band_voxels, kBandRange_voxels, "half width of the level set's band");
}

/// Formats a number in the shortest form that reads back as the same value: "0.1", "1000".
std::string ShowNumber(double number);
/// Returns the value of a setting as text. Throws Error for an unknown knob.
std::string ValueOf(const StudySettings& settings, const std::string& knob);
/// Sets a value from a text such as ValueOf() returns. Throws Error if the text is not a valid value; ranges are
/// checked when the study file is read.
void SetValue(StudySettings& settings, const std::string& knob, const std::string& value);
/// Lists all settings: "voxel_mm=0.1 rim_samples_per_pitch=16 ...".
std::string ShowSettings(const StudySettings& settings);

/// Returns the FNV-1a hash of a text, which is the same on every machine. It serves to distinguish texts and is not
/// suitable for security.
std::uint64_t HashText(std::string_view text);
/// Formats a hash as 16 hexadecimal digits.
std::string ShowHash(std::uint64_t hash);

}  // namespace kerf
