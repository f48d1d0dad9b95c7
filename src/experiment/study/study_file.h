// The study file (TOML), which lists the paths, ways of holding the tool and settings that a study compares, and the
// specification that is read from it.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "experiment/study/knobs.h"
#include "experiment/study/records.h"

namespace kerf {

/// A knob and its values.
struct KnobSweep {
  std::string knob;
  std::vector<std::string> values;  // as ValueOf() shows them
  std::vector<std::string> paths;   // only these; empty: all
  std::vector<Holding> holdings;    // only these; empty: all
};

/// A scene file as a path of the study.
struct StudyScene {
  std::string name;                // name of the path
  std::string file;                // absolute
  std::uint64_t content_hash = 0;  // of the file and of all files that it reads
};

struct StudySpec {
  std::string name;  // of the study file, without folder and extension
  std::string title;
  std::vector<std::string> paths;  // built-in ones, by name
  std::vector<StudyScene> scenes;
  std::vector<Holding> holdings{Holding::kHand, Holding::kPath};
  std::vector<std::string> cost_paths;  // the knobs' costs are measured on these paths only (if empty, on all paths);
                                        // the costs of the base settings are always measured on all paths
  int ticks_per_case = 20'000;          // timed ticks of each case for costs
  int ticks_of_defaults = 100'000;      // the same for the base settings
  double reference_tolerance = 1e-3;    // permitted change between two refinements, as a fraction of the force
  StudySettings base;
  bool names_law = false;  // [base] names a law; otherwise that of the scenes applies, if there are any
  std::vector<KnobSweep> knobs;
};

/// Throws Error with a line `file:line:column: ...` for each fault: unknown keys, wrong types, values out of range.
/// `built_in`: the names of the built-in paths. Does not read the scene files.
StudySpec ParseStudy(const std::string& text, const std::string& file, const std::vector<std::string>& built_in);
/// Also reads the scenes, for their law and their content_hash; reports their faults as `kerf check` does. Throws Error
/// if the scenes name different laws and [base] names none.
StudySpec ReadStudyFile(const std::string& file, const std::vector<std::string>& built_in);
/// Returns the default study as a file with comments.
std::string DefaultStudyToml();

/// Returns the complete specification as JSON, for a study folder. SpecFromJson() throws Error for anything that
/// SpecToJson() does not return.
nlohmann::ordered_json SpecToJson(const StudySpec& spec);
StudySpec SpecFromJson(const nlohmann::ordered_json& json);
/// Returns a hash of all inputs that the results depend on; the name, the title and the locations of the scene files
/// are not among them.
std::uint64_t HashOf(const StudySpec& spec);

}  // namespace kerf
