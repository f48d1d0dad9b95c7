#include "app/cli/log_columns.h"

namespace kerf::cli {
namespace {

/// Returns 1 if the step has the flag, 0 if not; the opposite if `inverted`.
auto HasFlag(std::uint32_t flag, bool inverted = false) {
  return [flag, inverted](const LogTickRow& r) { return ((r.step.flags & flag) != 0) != inverted ? 1 : 0; };
}

constexpr const char* kHandlePose = "pose of the handle; on a path, of the tool";

}  // namespace

const Columns<LogStateRow>& LogStateColumns() {
  using Row = LogStateRow;
  static const Columns<Row> kColumns = JoinColumns<Row>(
      {{{"step", "{}", "number of the step, counted from 1", [](const Row& r) { return r.state.step + 1; }},
        {"time_s", "{:.6f}", "its time", [](const Row& r) { return r.state.time_s; }}},
       PartsOf<Row>("handle_{}_mm", "xyz", "{:.6f}", kHandlePose, [](const Row& r) { return r.step.X.p_AB; }),
       PartsOf<Row>("handle_q{}", "wxyz", "{:.9f}", kHandlePose,
                    [](const Row& r) { return PartsOfQuat(r.step.X.R_AB); }),
       PartsOf<Row>("tool_{}_mm", "xyz", "{:.3f}", "position of the tool",
                    [](const Row& r) { return r.state.p_WT_mm; }),
       PartsOf<Row>("force_{}_N", "xyz", "{:.3f}", "force in the simulation on the hand; on a path, on the tool",
                    [](const Row& r) { return r.state.f_N; }),
       {{"removed_total_mm3", "{:.3f}", "total cut so far, by occupancy; undo does not reduce it",
         [](const Row& r) { return r.state.removed_mm3; }},
        {"engaged_teeth", "{:.3f}", "engaged arc / tooth pitch", [](const Row& r) { return r.state.engaged_teeth; }},
        {"rpm", "{:g}", "spindle speed; its sign is the sense about z of the tool",
         [](const Row& r) { return r.step.rpm; }},
        {"buttons", "{}", "pressed buttons", [](const Row& r) { return r.step.buttons; }}}});
  return kColumns;
}

const Columns<LogTickRow>& LogTickColumns() {
  using Row = LogTickRow;
  const char* const kDevice = "1 if the device returned a pose; 1 if it accepted the force; otherwise 0";
  const char* const kOff = "1 if there was no force in this tick; 1 if the tool was set down; otherwise 0";
  static const Columns<Row> kColumns = JoinColumns<Row>(
      {{{"step", "{}", "number of the step, counted from 1", &Row::number},
        {"time_s", "{:.6f}", "time at the end of the tick", &Row::time_s}},
       PartsOf<Row>("{}_mm", "xyz", "{:.7f}", kHandlePose, [](const Row& r) { return r.step.X.p_AB; }),
       PartsOf<Row>("q{}", "wxyz", "{:.10f}", kHandlePose, [](const Row& r) { return PartsOfQuat(r.step.X.R_AB); }),
       {{"dt_s", "{:.9g}", "time step of the simulation, at most 10 ms", [](const Row& r) { return r.step.dt_s; }},
        {"skipped", "{}", "deadlines missed before the tick", [](const Row& r) { return r.step.skipped; }},
        {"rpm", "{:g}", "spindle speed; its sign is the sense about z of the tool",
         [](const Row& r) { return r.step.rpm; }},
        {"buttons", "{}", "pressed buttons", [](const Row& r) { return r.step.buttons; }},
        {"read", "{}", kDevice, HasFlag(kRecordedReadFailed, true)},
        {"wrote", "{}", kDevice, HasFlag(kRecordedWriteFailed, true)},
        {"force_off", "{}", kOff, HasFlag(kRecordedForceOff)},
        {"set_down", "{}", kOff, HasFlag(kRecordedSetDown)},
        {"fidelity", "{}", "0 full, 1 coarse, 2 slab", [](const Row& r) { return r.step.fidelity; }},
        {"flags", "{}",
         "sum of 1 no pose read, 2 force not accepted, 4 force off, 8 set down, 16 a piece is about to be taken out, "
         "32 checkpoint, 64 undo, 128 redo, 256 session continued (\"taken up\"), 512 hand and tool moved without "
         "touching bone",
         [](const Row& r) { return r.step.flags; }},
        {"piece", "{}", "number of the piece", [](const Row& r) { return r.step.piece; }},
        {"checkpoint", "{}", "number of the checkpoint", [](const Row& r) { return r.step.checkpoint; }}}});
  return kColumns;
}

}  // namespace kerf::cli
