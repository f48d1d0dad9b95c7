// The conclusions of a comparison in words, derived from its measured figures alone.
#pragma once

#include <string>
#include <vector>

#include "experiment/compare/comparison.h"

namespace kerf {

/// One statement in each string, Markdown.
struct Conclusion {
  std::vector<std::string> force;    // first the overall one: whether slab mode can replace voxel mode
  std::vector<std::string> regions;  // first how the layers are named
  std::vector<std::string> beyond;   // the sources of the forces beyond the slice's end
  std::vector<std::string> cost;
};

/// Every figure, and every word that depends on one (more, less, agrees, ...), is taken from `comparison`; nothing is
/// assumed.
Conclusion WriteConclusion(const Comparison& comparison);

/// Returns 100 part / whole; 0 if `whole` is not positive.
double Percent(double part, double whole);
/// "350 us", "0.42 us", "1.2 ms": three digits.
std::string ShowTime(double us);
/// "13.1 MB", "2.4 kB", "96 bytes": three digits.
std::string ShowMemory(double bytes);
/// Three digits, never with an exponent.
std::string ShowFigure(double value);

}  // namespace kerf
