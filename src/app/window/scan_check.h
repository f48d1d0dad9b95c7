// Questions about a CT that was read, which the user answers by its slices: from which value on it is bone, if its
// values are no Hounsfield units, and where its slices lie, if that was assumed.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "app/window/ct_preview.h"
#include "bone/import/import.h"

namespace kerf {

class ScanCheck {
 public:
  enum class Answer { kNone, kImport, kCancel };

  /// `placing`, `values`: what is asked about; at least one of them.
  ScanCheck(std::shared_ptr<const Volume> ct, const std::optional<AssumedPlacing>& placing,
            const std::optional<NotHu>& values);

  void Ask() { asks_ = true; }
  /// Returns true while something is asked; false while the CT is imported with the answers.
  bool asks() const { return asks_; }
  void EndAsking() { asks_ = false; }
  // The answers, as options of the import.
  std::optional<double> iso() const { return values_ ? std::optional(value_) : std::nullopt; }
  double spacing_z_mm() const;  // 0: the file states it, or the user has not given it yet
  std::string frame() const;    // empty: the file states it
  /// Returns false while the import lacks an answer.
  bool is_answered() const { return !lacks_spacing() || spacing_mm_ > 0; }
  /// Returns whether Enter is enough to import. Assumed places must be confirmed by a click.
  bool takes_enter() const { return !placing_; }

  /// Returns the threshold of bone in HU.
  double CalcIsoHu() const;
  /// Returns the grey levels with which slices show the CT, with bone tinted: in its own values, or in those to which
  /// the import converts them.
  CtGreys CalcGreys(bool converted) const;

  /// Draws what is asked over the scene, and the slices in it and in the column.
  Answer Draw(Ui& ui, const UiBox& scene, const UiBox& column, CtPreview& slices);
  void Describe(nlohmann::json& state) const;

 private:
  /// Returns whether nothing in the file gives the distance between the slices.
  bool lacks_spacing() const { return placing_ && placing_->spacing_mm && placing_->spacing_from.empty(); }
  /// Draws the field of that distance, empty while it is unknown. Returns true if the user has changed it.
  bool DrawSpacing(Ui& ui);
  void DrawPlacing(Ui& ui, CtPreview& slices);
  void DrawThreshold(Ui& ui, CtPreview& slices);
  void DrawHistogram(Ui& ui, float width) const;
  void Place();

  std::shared_ptr<const Volume> ct_;
  std::shared_ptr<const Volume> shown_;  // the CT as its slices are now said to lie
  std::optional<AssumedPlacing> placing_;
  std::optional<NotHu> values_;
  bool asks_ = false;
  double value_ = 0;               // threshold, in the CT's own values
  double spacing_mm_ = 0;          // as given; 0: not changed
  std::array<bool, 3> swapped_{};  // directions of x, y and z
  ValueHistogram histogram_;
};

}  // namespace kerf
