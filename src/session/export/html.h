// Pieces of HTML.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace kerf::takeaway {

/// Text as it may stand in an element or a quoted attribute; what is no character of XML is left out.
std::string Escape(std::string_view text);
/// RFC 4648.
std::string Base64(std::string_view bytes);

/// A table: text is escaped here. Cells of the first column are left, the others right unless `text` says all left.
std::string Table(const std::vector<std::string>& heads, const std::vector<std::vector<std::string>>& rows,
                  bool text = false);
/// "-" for none of a number; else with so many decimals. Never "-0.00".
std::string Show(double value, int decimals);

}  // namespace kerf::takeaway
