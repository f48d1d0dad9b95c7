// Tables and sentences of a study's report, Markdown; all made from its figures.
#pragma once

#include <string>

#include "experiment/study/pooled.h"

namespace kerf {

/// Three digits that count: "2.98", "0.0312", "1230".
std::string ShowThree(double value);
/// A share in per cent: "2.98 %", "at most 0.12 %".
std::string ShowError(const SafeError& error);
std::string ShowShare(double share);
/// "+2.98 %", "-14.1 %", "0 %".
std::string ShowSignedShare(double share);

/// Each ends in an empty line; empty when there is nothing to tell.
std::string DefaultsTable(const StudyResults& study, Holding holding);
std::string EqualTimeTable(const StudyResults& study, Holding holding);
std::string EqualErrorTable(const StudyResults& study, Holding holding);
std::string SettingsTable(const StudyResults& study, Holding holding);
std::string OrdersTable(const StudyResults& study, Holding holding);
std::string SlabTable(const StudyResults& study, Holding holding);
std::string LeftOutTable(const StudyResults& study);
std::string ReferencesTable(const StudyResults& study);

/// What was found with the tool held so, a bullet each.
std::string DescribeFindings(const StudyResults& study, Holding holding);

/// The paths on which slab mode was done.
std::vector<std::string> PathsOfSlab(const StudyResults& study, Holding holding);

}  // namespace kerf
