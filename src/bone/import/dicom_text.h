// Values of a DICOM file's header as texts and numbers.
#pragma once

#include <gdcmStringFilter.h>

#include <cstdint>
#include <string>
#include <vector>

namespace kerf {

/// Returns the value of an element as text, without the padding at its end; empty if it is missing.
std::string GetText(gdcm::StringFilter& filter, std::uint16_t group, std::uint16_t element);

/// Returns the numbers of an element; none if it is missing.
std::vector<double> GetNumbers(gdcm::StringFilter& filter, std::uint16_t group, std::uint16_t element);

/// Returns the first number of an element, from 0 to 1e6; `otherwise` if it has none.
int GetInteger(gdcm::StringFilter& filter, std::uint16_t group, std::uint16_t element, int otherwise);

}  // namespace kerf
