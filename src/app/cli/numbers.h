// Numbers that people type on the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf::cli {

/// A finite decimal number and nothing else but spaces about it; not hexadecimal, "nan" or "inf".
std::optional<double> ParseNumber(const std::string& text);
/// Just `count` of them between separators. Throws CLI::ValidationError: "'text' must be `form`".
std::vector<double> ParseNumbers(const std::string& text, char separator, std::size_t count, const char* option,
                                 const char* form);
/// x,y,z in mm within the world's coordinates. Throws CLI::ValidationError.
Vec3 ParsePoint(const std::string& text, const char* option);
/// Says what is no number as such, and what is out of range with range and unit.
CLI::Validator NumberWithin(double lower, double upper, const char* unit);

}  // namespace kerf::cli
