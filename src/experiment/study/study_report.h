// The complete report of a study, generated from its raw figures alone.
#pragma once

#include <functional>
#include <string>

#include "experiment/study/study_csv.h"

namespace kerf {

/// Writes cases.csv, cases_times.csv, references.csv, the figures as PNG and SVG, report.md and finally study.json into
/// the folder, which must exist. Removes figures of an earlier report that are now obsolete. The same results always
/// produce the same bytes. `progress` (may be empty) receives the current step. Throws Error if a file cannot be
/// written.
void WriteStudyReport(const StudyResults& study, const std::string& folder,
                      const std::function<void(const std::string&)>& progress);

}  // namespace kerf
