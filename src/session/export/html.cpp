#include "session/export/html.h"

#include <fmt/format.h>
#include <sodium.h>

#include <cmath>

#include "base/core/number_text.h"
#include "base/files/html_text.h"
#include "session/export/write_export.h"

namespace kerf::export_detail {

std::string Base64(std::string_view bytes) {
  std::string out(sodium_base64_encoded_len(bytes.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(out.data(), out.size(), reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
                    sodium_base64_VARIANT_ORIGINAL);
  out.pop_back();  // the terminating zero
  return out;
}

std::string Table(const std::vector<std::string>& headers, const TableRows& rows, bool text) {
  std::string out = text ? "<table class=\"text\">\n<thead><tr>" : "<table>\n<thead><tr>";
  for (const std::string& header : headers) out += fmt::format("<th scope=\"col\">{}</th>", EscapeHtml(header));
  out += "</tr></thead>\n<tbody>\n";
  for (const auto& row : rows) {
    out += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string_view tag = i == 0 ? "th scope=\"row\"" : "td";
      out += fmt::format("<{}>{}", tag, EscapeHtml(row[i].text));
      if (!row[i].technical.empty()) {
        out += fmt::format("<span class=\"technical\">{}</span>", EscapeHtml(row[i].technical));
      }
      out += i == 0 ? "</th>" : "</td>";
    }
    out += "</tr>\n";
  }
  return out + "</tbody>\n</table>\n";
}

std::string Show(double value, int decimals) {
  if (!std::isfinite(value)) return "-";
  const double unit = std::pow(10.0, -decimals);
  if (std::abs(value) < 0.5 * unit) value = 0;
  return fmt::format("{:.{}f}", value, decimals);
}

}  // namespace kerf::export_detail

namespace kerf {

std::string ReportLanguage::ShowName(const std::string& name) const {
  const std::size_t space = name.find_last_of(' ');
  const bool numbered = space != std::string::npos && space + 1 < name.size() &&
                        name.find_first_not_of("0123456789", space + 1) == std::string::npos;
  const std::string base = numbered ? name.substr(0, space) : name;
  const std::string ending = numbered ? name.substr(space) : std::string();
  const std::pair<std::string_view, std::string> words[] = {
      {"plane", Tr("plane")},   {"stop", Tr("stop")},         {"piece", Tr("piece")}, {"nerve", Tr("nerve")},
      {"canal", Tr("canal")},   {"tooth", Tr("tooth")},       {"root", Tr("root")},   {"other", Tr("other")},
      {"lesion", Tr("lesion")}, {"distance", Tr("distance")}, {"angle", Tr("angle")}};
  for (const auto& [word, shown] : words) {
    if (base == word) return shown + ending;
  }
  return name;
}

std::string ReportLanguage::ShowSaw(const std::string& saw) const {
  const std::size_t colon = saw.find(": ");
  if (colon == std::string::npos) return Tr(saw);
  return fmt::format("{}: {}", Tr(saw.substr(0, colon)), Tr(saw.substr(colon + 2)));
}

std::string ReportLanguage::Show(double value, int decimals) const {
  std::string text = export_detail::Show(value, decimals);
  if (const std::size_t dot = text.find('.'); dot != std::string::npos) text.replace(dot, 1, point);
  return text;
}

std::string ReportLanguage::ShowVolume(double mm3) const {
  const ShownVolume shown = ChooseVolumeUnit(mm3);
  return fmt::format("{} {}", Show(shown.value, shown.decimals), shown.unit);
}

std::string ReportLanguage::Show(const Message& message) const {
  return FormatMessage(
      message, [this](const std::string& text) { return ShowName(Tr(text)); }, point);
}

}  // namespace kerf
