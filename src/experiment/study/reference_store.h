// References on disk: computed once, and reused while their inputs are unchanged.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "experiment/study/case.h"

namespace kerf {

/// Reads a stored reference without its bone. Returns nullopt if there is no such file, or if it has another input.
/// Throws Error if the file is damaged or not a reference.
std::optional<StudyReference> ReadStudyReference(const std::string& file, std::uint64_t input_hash);
/// Writes atomically: an existing file stays intact until the new one is complete. Throws Error if it cannot be
/// written.
void WriteStudyReference(const StudyReference& reference, const std::string& file);

}  // namespace kerf
