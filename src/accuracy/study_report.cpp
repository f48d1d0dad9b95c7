#include "accuracy/study_report.h"

#include "files/files.h"

namespace kerf {

void WriteStudyReport(const StudyResults& study, const std::string& folder,
                      const std::function<void(const std::string&)>& progress) {
  if (progress) progress("tables");
  WriteTextFile(folder + "/cases.csv", FormatCasesCsv(study));
  WriteTextFile(folder + "/cases_times.csv", FormatTimesCsv(study));
  WriteTextFile(folder + "/references.csv", FormatReferencesCsv(study));
  WriteTextFile(folder + "/study.json", FormatStudyJson(study, {}));
}

}  // namespace kerf
