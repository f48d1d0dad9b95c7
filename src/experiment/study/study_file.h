// The study file (TOML): which paths, ways of holding and settings a study compares, and how finely.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "experiment/study/knobs.h"
#include "experiment/study/records.h"

namespace kerf {

/// A knob and the values that it is turned to.
struct KnobSweep {
  std::string knob;
  std::vector<std::string> values;  // as ValueOf() shows them
  std::vector<std::string> paths;   // only these; empty: all
  std::vector<Holding> holdings;    // only these; empty: all
};

/// A scene file as a path of the study.
struct StudyScene {
  std::string name;                // as a path's
  std::string file;                // absolute
  std::uint64_t content_hash = 0;  // of the file and of all that it reads
};

struct StudySpec {
  std::string name;  // of the study file, without folder and extension
  std::string title;
  std::vector<std::string> paths;  // built-in ones, by name
  std::vector<StudyScene> scenes;
  std::vector<Holding> holdings{Holding::kHand, Holding::kPath};
  std::vector<std::string> cost_paths;  // the knobs' costs only on these; empty: on all; the base settings' on all
  int ticks_per_case = 20'000;          // timed, of each case for costs
  int ticks_of_defaults = 100'000;      // the same for the base settings
  double reference_tolerance = 1e-3;    // between two refinements, a share of the force
  StudySettings base;
  std::vector<KnobSweep> knobs;
};

/// Throws Error with a line `file:line:column: ...` for each fault: unknown keys, wrong types, values out of range.
/// `built_in`: the names of the paths that there are. Does not look at the scenes' files.
StudySpec ParseStudy(const std::string& text, const std::string& file, const std::vector<std::string>& built_in);
/// Reads the scenes too, for their content_hash; their faults are told as `kerf check` does.
StudySpec ReadStudyFile(const std::string& file, const std::vector<std::string>& built_in);
/// The default study as a commented file.
std::string DefaultStudyToml();

/// JSON: all of it, for a study's folder. SpecFromJson() throws Error for what SpecToJson() does not write.
std::string SpecToJson(const StudySpec& spec);
StudySpec SpecFromJson(const std::string& text);
/// Of all that results depend on: not of name, title and where the scenes' files lie.
std::uint64_t HashOf(const StudySpec& spec);

}  // namespace kerf
