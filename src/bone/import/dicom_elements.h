// Elements of a DICOM data set that GDCM has read.
#pragma once

#include <gdcmDataSet.h>
#include <gdcmSequenceOfItems.h>

#include <cstdint>
#include <string>
#include <vector>

namespace kerf {

using DicomSequence = gdcm::SmartPointer<gdcm::SequenceOfItems>;

/// Returns a text without the padding at its end; empty if it is missing.
std::string ReadText(const gdcm::DataSet& data, std::uint16_t group, std::uint16_t element);

/// Returns the numbers of a text such as "1.5\\-2"; none if it is missing.
std::vector<double> ReadNumbers(const gdcm::DataSet& data, std::uint16_t group, std::uint16_t element);

/// Returns a number of two bytes, little-endian; 0 if it is missing.
int ReadShort(const gdcm::DataSet& data, std::uint16_t group, std::uint16_t element);

/// Returns the items of a sequence; none if it is missing. They are valid as long as `kept` is.
std::vector<const gdcm::DataSet*> ReadItems(const gdcm::DataSet& data, std::uint16_t group, std::uint16_t element,
                                            std::vector<DicomSequence>& kept);

}  // namespace kerf
