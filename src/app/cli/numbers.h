// Parsing of numbers on the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf::cli {

/// Parses a finite decimal number, optionally surrounded by spaces. Does not accept hexadecimal, "nan" or "inf".
std::optional<double> ParseNumber(const std::string& text);
/// Parses exactly `count` numbers between separators. Throws CLI::ValidationError: "'text' must be `form`".
std::vector<double> ParseNumbers(const std::string& text, char separator, std::size_t count, const char* option,
                                 const char* form);
/// Parses x,y,z in mm within the world's coordinates. Throws CLI::ValidationError.
Vec3 ParsePoint(const std::string& text, const char* option);
/// Returns a validator that distinguishes text that is not a number from a number that is out of range. Its message
/// states the range and the unit.
CLI::Validator NumberWithin(double lower, double upper, const char* unit);

}  // namespace kerf::cli
