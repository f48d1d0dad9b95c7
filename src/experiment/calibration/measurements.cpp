#include "experiment/calibration/measurements.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>

#include "base/core/csv.h"
#include "base/core/nearest_name.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr Range kForceRange_N{0, 1e5};
constexpr Range kTorqueRange_N_mm{0, 1e7};
constexpr std::size_t kMaxRows = 100000;
constexpr std::size_t kMaxSpecimenName = 200;

/// Returns the column that the user probably meant, or "". A name without its unit is recognised.
std::string SuggestColumn(const std::string& name) {
  std::vector<std::string> names;
  for (const MeasurementColumn& column : MeasurementColumns()) {
    if (!name.empty() && std::string_view(column.name).starts_with(name + "_")) return column.name;
    names.emplace_back(column.name);
  }
  return FindNearestName(name, names);
}

void CheckKnown(const CsvHeaderLine& header, const std::string& file) {
  const auto& columns = MeasurementColumns();
  const CsvPlace place{file, header.line};
  for (const std::string& name : header.names) {
    if (std::any_of(columns.begin(), columns.end(), [&](const MeasurementColumn& c) { return c.name == name; }))
      continue;
    const std::string nearest = SuggestColumn(name);
    if (!nearest.empty()) place.Fail(fmt::format("unknown column {}; did you mean \"{}\"?", Quote(name), nearest));
    std::string all;
    for (const MeasurementColumn& column : columns) all.append(all.empty() ? "" : ", ").append(column.name);
    place.Fail(fmt::format("unknown column {}; the columns are {}", Quote(name), all));
  }
}

/// A measured quantity: the columns of its values and standard deviations.
struct MeasuredQuantity {
  const char* value;
  const char* sd;
  ForceComponent component;
};
constexpr MeasuredQuantity kQuantities[] = {{"thrust_N", "thrust_sd_N", ForceComponent::kThrust},
                                            {"cutting_N", "cutting_sd_N", ForceComponent::kCutting},
                                            {"torque_N_mm", "torque_sd_N_mm", ForceComponent::kCutting}};

/// Reads the rows of one file.
class MeasurementReader {
 public:
  explicit MeasurementReader(std::vector<std::string> header) : header_(std::move(header)) {}

  bool Has(std::string_view column) const { return Find(column) < header_.size(); }

  /// Throws kerf::Error if columns are missing that belong to those present.
  void CheckHeader(const CsvPlace& place) const {
    const auto need = [&](std::string_view column, std::string_view why) {
      if (!Has(column)) place.Fail(fmt::format("column \"{}\" is missing{}", column, why));
    };
    need("bite_mm", "");
    need("width_mm", "");
    bool any = false;
    for (const MeasuredQuantity& q : kQuantities) {
      any = any || Has(q.value);
      if (Has(q.sd)) need(q.value, fmt::format("; \"{}\" is its standard deviation", q.sd));
    }
    if (!any) place.Fail("no measured force; give a column thrust_N, cutting_N or torque_N_mm");
    if (Has("torque_N_mm")) need("radius_mm", "; a torque needs the radius at which the force acts");
    if (Has("radius_mm")) need("torque_N_mm", "; \"radius_mm\" is used only with a torque");
    if (Has("cutting_N") && Has("torque_N_mm") && Has("cutting_sd_N") != Has("torque_sd_N_mm")) {
      place.Fail("standard deviations are given for only one of cutting_N and torque_N_mm");
    }
  }

  void AddRow(const std::vector<std::string>& fields, const CsvPlace& place) {
    if (data_.rows() == kMaxRows) place.Fail(fmt::format("more than {} rows", kMaxRows));
    fields_ = &fields;
    place_ = &place;
    ForceObservation o{};
    o.row = data_.rows();
    o.bite_mm = Number("bite_mm");
    o.width_mm = Number("width_mm") * (Has("teeth") ? Number("teeth") : 1);
    if (Has("speed_mm_per_s")) o.speed_mm_per_s = Number("speed_mm_per_s");
    bool any = false;
    for (const MeasuredQuantity& q : kQuantities) any = AddValue(q, o) || any;
    if (!any) place.Fail("the row has no force and no torque");
    data_.group_of_row.push_back(Has("specimen") ? Specimen() : 0);
  }

  Measurements Finish(const std::string& file) {
    if (data_.rows() == 0) throw Error(fmt::format("{}: no rows below the header", file));
    if (std::ranges::all_of(data_.observations, [](const ForceObservation& o) { return o.force_N == 0; })) {
      throw Error(fmt::format("{}: all forces are 0", file));
    }
    data_.specimens = specimens_.size();
    data_.groups = data_.specimens;
    if (data_.specimens < 2) {
      for (std::size_t i = 0; i < data_.rows(); ++i) data_.group_of_row[i] = i;
      data_.groups = data_.rows();
    }
    return std::move(data_);
  }

 private:
  std::size_t Find(std::string_view column) const {
    return static_cast<std::size_t>(std::find(header_.begin(), header_.end(), column) - header_.begin());
  }
  const std::string& Field(std::string_view column) const { return (*fields_)[Find(column)]; }

  /// Returns the number in the column of this row.
  double Number(const char* column) const {
    const std::string& text = Field(column);
    if (text.empty()) place_->Fail(fmt::format("{} is empty", column));
    const double value = ParseCsvNumber(text, 0, column, *place_);
    const auto& columns = MeasurementColumns();
    const auto found = std::find_if(columns.begin(), columns.end(),
                                    [&](const MeasurementColumn& c) { return std::string_view(c.name) == column; });
    const std::string fault = FindRangeFault(value, found->range, UnitOfKey(column));
    if (!fault.empty()) place_->Fail(fmt::format("{} = {} {}", column, text, fault));
    return value;
  }

  /// Returns true if the row has a value of that quantity.
  bool AddValue(const MeasuredQuantity& q, ForceObservation o) {
    if (!Has(q.value)) return false;
    if (Field(q.value).empty()) {
      if (Has(q.sd) && !Field(q.sd).empty()) place_->Fail(fmt::format("{} is given without {}", q.sd, q.value));
      return false;
    }
    const double radius_mm = std::string_view(q.value) == "torque_N_mm" ? Number("radius_mm") : 1;
    o.component = q.component;
    o.force_N = Number(q.value) / radius_mm;
    o.sd_N = Has(q.sd) ? Number(q.sd) / radius_mm : 0;
    data_.observations.push_back(o);
    return true;
  }

  std::size_t Specimen() {
    const std::string& name = Field("specimen");
    if (name.empty()) place_->Fail("specimen is empty");
    if (name.size() > kMaxSpecimenName) {
      place_->Fail(fmt::format("specimen {} is longer than {} characters", Quote(name), kMaxSpecimenName));
    }
    return specimens_.emplace(name, specimens_.size()).first->second;
  }

  std::vector<std::string> header_;
  Measurements data_;
  std::map<std::string, std::size_t> specimens_;
  const std::vector<std::string>* fields_ = nullptr;  // of the row that is read
  const CsvPlace* place_ = nullptr;
};

/// Returns the columns of the file that are known; ReadCsv() reports the others and those that are given twice.
std::vector<std::string> SelectKnown(const std::vector<std::string>& header) {
  std::vector<std::string> known;
  for (const MeasurementColumn& column : MeasurementColumns()) {
    if (std::find(header.begin(), header.end(), column.name) != header.end()) known.emplace_back(column.name);
  }
  return known;
}

}  // namespace

const std::vector<MeasurementColumn>& MeasurementColumns() {
  static const std::vector<MeasurementColumn> kColumns{
      {"bite_mm", {1e-6, 1}, "thickness of the layer that one tooth cuts; required"},
      {"width_mm", {1e-3, 100}, "width of one tooth; required"},
      {"teeth", {1e-3, 1000}, "number of teeth that cut at the same time and share the force or torque; default 1"},
      {"speed_mm_per_s", {0, 1e6}, "cutting speed; only tested for an influence on the residuals"},
      {"thrust_N", kForceRange_N, "thrust, normal to the cut surface; may be empty"},
      {"thrust_sd_N", {1e-9, kForceRange_N.upper}, "its standard deviation; the weight of the value is 1 / SD^2"},
      {"cutting_N", kForceRange_N, "cutting force, against the motion of the tooth; may be empty"},
      {"cutting_sd_N", {1e-9, kForceRange_N.upper}, "its standard deviation"},
      {"torque_N_mm", kTorqueRange_N_mm, "torque; torque divided by radius is taken as a cutting force; may be empty"},
      {"torque_sd_N_mm", {1e-9, kTorqueRange_N_mm.upper}, "its standard deviation"},
      {"radius_mm", {1e-3, 1000}, "radius at which the cutting force of the torque acts; required with a torque"},
      {"specimen", {0, 0}, "name of the specimen; the bootstrap resamples specimens if there are at least two"}};
  return kColumns;
}

Measurements ParseMeasurements(const std::string& text, const std::string& file) {
  const CsvHeaderLine header = ReadCsvHeader(text);
  if (header.names.empty()) throw Error(fmt::format("{}: no header; it needs bite_mm, width_mm and a force", file));
  CheckKnown(header, file);
  const std::vector<std::string> columns = SelectKnown(header.names);
  MeasurementReader reader(columns);
  reader.CheckHeader({file, header.line});
  ReadCsv(text, file, columns, [&](const auto& fields, const CsvPlace& place) { reader.AddRow(fields, place); });
  return reader.Finish(file);
}

}  // namespace kerf
