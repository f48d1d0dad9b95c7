#include "bone/import/dicom_elements.h"

#include <algorithm>
#include <sstream>

namespace kerf {

std::string ReadText(const gdcm::DataSet& data, std::uint16_t group, std::uint16_t element) {
  const gdcm::Tag tag(group, element);
  if (!data.FindDataElement(tag)) return "";
  const gdcm::ByteValue* bytes = data.GetDataElement(tag).GetByteValue();
  if (bytes == nullptr || bytes->GetPointer() == nullptr) return "";
  std::string text(bytes->GetPointer(), bytes->GetLength());
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text;
}

std::vector<double> ReadNumbers(const gdcm::DataSet& data, std::uint16_t group, std::uint16_t element) {
  std::string text = ReadText(data, group, element);
  std::replace(text.begin(), text.end(), '\\', ' ');
  std::istringstream in(text);
  std::vector<double> numbers;
  for (double v = 0; in >> v;) numbers.push_back(v);
  return numbers;
}

int ReadShort(const gdcm::DataSet& data, std::uint16_t group, std::uint16_t element) {
  const gdcm::Tag tag(group, element);
  if (!data.FindDataElement(tag)) return 0;
  const gdcm::ByteValue* bytes = data.GetDataElement(tag).GetByteValue();
  if (bytes == nullptr || bytes->GetLength() < 2) return 0;
  const char* const two = bytes->GetPointer();
  if (two == nullptr) return 0;
  return static_cast<unsigned char>(two[0]) + 256 * static_cast<unsigned char>(two[1]);
}

std::vector<const gdcm::DataSet*> ReadItems(const gdcm::DataSet& data, std::uint16_t group, std::uint16_t element,
                                            std::vector<DicomSequence>& kept) {
  const gdcm::Tag tag(group, element);
  if (!data.FindDataElement(tag)) return {};
  const DicomSequence sequence = data.GetDataElement(tag).GetValueAsSQ();
  if (!sequence) return {};
  kept.push_back(sequence);
  std::vector<const gdcm::DataSet*> items;
  for (std::size_t i = 1; i <= sequence->GetNumberOfItems(); ++i) {
    items.push_back(&sequence->GetItem(i).GetNestedDataSet());
  }
  return items;
}

}  // namespace kerf
