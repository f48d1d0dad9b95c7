// The conclusions of a comparison in words, derived from its measured figures alone.
#pragma once

#include <string>
#include <vector>

#include "experiment/compare/comparison.h"

namespace kerf {

/// Each string is one statement in Markdown.
struct Conclusion {
  std::vector<std::string> force;    // begins with the overall one: whether slab mode can replace voxel mode
  std::vector<std::string> regions;  // begins with an explanation of the layers' names
  std::vector<std::string> beyond;   // the sources of the forces beyond the slice's end
  std::vector<std::string> cost;
};

/// Every figure, and every word that depends on one (more, less, agrees, ...), is taken from `comparison`; nothing is
/// assumed.
Conclusion WriteConclusion(const Comparison& comparison);

/// Returns 100 part / whole; 0 if `whole` is not positive.
double Percent(double part, double whole);
/// Formats a time as ShowFigure() does, in ms from 10 ms on: "350 us", "0.420 us", "12.0 ms".
std::string ShowTime(double us);
/// Formats a size in memory: "13.1 MB", "2.40 kB", "96 bytes".
std::string ShowMemory(double bytes);
/// Formats with three significant digits, but as a whole number from 100 on and with at most six decimals; never with
/// an exponent.
std::string ShowFigure(double value);

}  // namespace kerf
