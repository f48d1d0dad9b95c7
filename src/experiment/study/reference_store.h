// References on disk: worked out once, read back as long as nothing that they came from has changed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "experiment/study/case.h"

namespace kerf {

/// What was stored, but for the bone; none when there is no such file, or when it is of another input. Throws Error for
/// a file that is damaged or none of these.
std::optional<StudyReference> ReadStudyReference(const std::string& file, std::uint64_t input_hash);
/// Safely: an earlier file is whole until the new one is. Throws Error.
void WriteStudyReference(const StudyReference& reference, const std::string& file);

}  // namespace kerf
