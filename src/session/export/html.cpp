#include "session/export/html.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>

namespace kerf::export_detail {

std::string Escape(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        if (byte >= 0x20 || c == '\n' || c == '\t') out += c;
    }
  }
  return out;
}

std::string Base64(std::string_view bytes) {
  static constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t byte = i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u;
      group = group << 8 | byte;
    }
    const std::size_t left = bytes.size() - i;
    for (std::size_t k = 0; k < 4; ++k) {
      const bool pad = k > left;
      out += pad ? '=' : kDigits[group >> (18 - 6 * k) & 63];
    }
  }
  return out;
}

std::string Table(const std::vector<std::string>& headers, const std::vector<std::vector<std::string>>& rows,
                  bool text) {
  std::string out = text ? "<table class=\"text\">\n<thead><tr>" : "<table>\n<thead><tr>";
  for (const std::string& header : headers) out += fmt::format("<th scope=\"col\">{}</th>", Escape(header));
  out += "</tr></thead>\n<tbody>\n";
  for (const auto& row : rows) {
    out += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string_view tag = i == 0 ? "th scope=\"row\"" : "td";
      out += fmt::format("<{}>{}</{}>", tag, Escape(row[i]), i == 0 ? "th" : "td");
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
