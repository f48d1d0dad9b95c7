#include "bone/import/dicom_text.h"

#include <algorithm>
#include <sstream>

namespace kerf {

std::string GetText(gdcm::StringFilter& filter, std::uint16_t group, std::uint16_t element) {
  std::string text = filter.ToString(gdcm::Tag(group, element));
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text;
}

std::vector<double> GetNumbers(gdcm::StringFilter& filter, std::uint16_t group, std::uint16_t element) {
  std::string text = GetText(filter, group, element);
  std::replace(text.begin(), text.end(), '\\', ' ');
  std::istringstream in(text);
  std::vector<double> numbers;
  for (double v = 0; in >> v;) numbers.push_back(v);
  return numbers;
}

int GetInteger(gdcm::StringFilter& filter, std::uint16_t group, std::uint16_t element, int otherwise) {
  const std::vector<double> numbers = GetNumbers(filter, group, element);
  return numbers.empty() ? otherwise : static_cast<int>(std::clamp(numbers[0], 0.0, 1e6));
}

}  // namespace kerf
