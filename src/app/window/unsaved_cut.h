// Whether the bone has changed since the project was last saved.
#pragma once

#include <cstdint>

namespace kerf {

class UnsavedCut {
 public:
  /// Called once per frame, and at the end of a session. `changes`: LiveFigures::changes of the running session, which
  /// begin at 0.
  void Follow(std::uint64_t changes) {
    unsaved_ = unsaved_ || changes > followed_;
    followed_ = changes;
  }
  bool is_unsaved() const { return unsaved_; }
  void set_unsaved(bool unsaved) { unsaved_ = unsaved; }

 private:
  std::uint64_t followed_ = 0;
  bool unsaved_ = false;
};

}  // namespace kerf
