// A study's raw figures in a folder: cases.csv, cases_times.csv, references.csv and study.json. What is drawn and said
// of a study is made from them alone.
#pragma once

#include <string>
#include <vector>

#include "experiment/study/records.h"

namespace kerf {

/// One row a case. Columns end in their unit; `_jnd`: the column before in just-noticeable differences (records.h). No
/// value: an empty field. Numbers read back to the same bits; control characters in words become spaces.
std::string FormatCasesCsv(const StudyResults& study);
/// The times of every tick: id, bucket of LogHistogram, its upper edge (us), ticks in it.
std::string FormatTimesCsv(const StudyResults& study);
std::string FormatReferencesCsv(const StudyResults& study);
/// All else. `files`: names of what stands beside it.
std::string FormatStudyJson(const StudyResults& study, const std::vector<std::string>& files);

/// Reads the four files of a folder again. Throws Error for the first fault, a sentence with file and line.
StudyResults ReadStudyResults(const std::string& folder);

}  // namespace kerf
