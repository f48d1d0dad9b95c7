// Threshold of bone in a CT whose values are no Hounsfield units, chosen by the user in its slices.
#pragma once

#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "app/window/ct_preview.h"

namespace kerf {

class BoneThreshold {
 public:
  enum class Answer { kNone, kImport, kCancel };

  /// `proposed`: in the CT's own values, like all thresholds.
  BoneThreshold(std::shared_ptr<const Volume> ct, double proposed);

  /// Asks for the threshold. `why`: why it is needed, in the language of the window; empty: as before.
  void Ask(const std::string& why);
  /// Returns true while the threshold is asked for; false while the CT is imported with it.
  bool asks() const { return asks_; }
  void EndAsking() { asks_ = false; }
  double value() const { return value_; }
  /// Returns the grey levels with which slices show the CT, with bone tinted.
  CtGreys greys() const;

  /// Draws what is asked over the scene, and the slices in it and in the column.
  Answer Draw(Ui& ui, const UiBox& scene, const UiBox& column, CtPreview& slices);
  void Describe(nlohmann::json& state) const;

 private:
  std::shared_ptr<const Volume> ct_;
  bool asks_ = false;
  std::string why_;
  double value_;
  double darkest_;  // values that nearly all voxels lie between
  double brightest_;
};

}  // namespace kerf
