// What a reader should conclude from a comparison, in words, from its measured figures alone.
#pragma once

#include <string>
#include <vector>

#include "experiment/compare/comparison.h"

namespace kerf {

/// One statement each, Markdown.
struct Conclusion {
  std::vector<std::string> force;    // the whole first: can slab mode stand in
  std::vector<std::string> regions;  // how layers are named the first
  std::vector<std::string> beyond;   // whose force past the slice's end is from what
  std::vector<std::string> cost;
};

/// Every figure and every word that follows from one (more, less, agrees, ...) is taken
/// from `comparison`; nothing is known beforehand.
Conclusion WriteConclusion(const Comparison& comparison);

/// "350 us", "0.42 us", "1.2 ms": three figures.
std::string ShowTime(double us);
/// "13.1 MB", "2.4 kB", "96 bytes": three figures.
std::string ShowMemory(double bytes);
/// Three figures, never an exponent.
std::string ShowFigure(double value);

}  // namespace kerf
