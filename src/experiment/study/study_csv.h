// The raw figures of a study in a folder: cases.csv, cases_times.csv, references.csv and study.json. All diagrams and
// reports of a study are generated from these files alone.
#pragma once

#include <string>
#include <vector>

#include "base/table/table.h"
#include "experiment/study/records.h"

namespace kerf {

// CaseColumns() of cases.csv: a column ending in `_jnd` contains the preceding one in just-noticeable differences
// (records.h). A missing value is an empty field. Numbers read back bit for bit; control characters in words become
// spaces.
const Columns<CaseRecord>& CaseColumns();
const Columns<ReferenceRecord>& ReferenceColumns();  // of references.csv; also the keys of a stored reference

/// A row of cases_times.csv: the number of ticks of a case in a bucket of LogHistogram.
struct BucketRow {
  std::string id;
  int bucket = 0;
  std::uint64_t count = 0;
};
const Columns<BucketRow>& BucketColumns();
std::vector<BucketRow> ListBuckets(const StudyResults& study);

/// Formats all other data. `files`: names of the other files in the folder.
std::string FormatStudyJson(const StudyResults& study, const std::vector<std::string>& files);

/// Reads the four files of a folder. Throws Error for the first fault, giving file and line.
StudyResults ReadStudyResults(const std::string& folder);

}  // namespace kerf
