#include "loop/haptics/restore_exchange.h"

namespace kerf {

void RestoreExchange::Begin(CoupledSimulation& simulation, bool wait, TickInputs& in) {
  if (wait || restore_.running()) return;
  const Request* next = ring_.Peek();
  if (next == nullptr) return;
  const Request request = *next;
  if (request.job == nullptr) {
    if (!simulation.Checkpoint(request.checkpoint)) return;
    ring_.Pop();
    in.flags |= kRecordedCheckpoint;
    in.checkpoint = request.checkpoint;
    return;
  }
  ring_.Pop();
  // These are copied first, since the job may be destroyed as soon as its refusal is reported.
  const std::uint32_t flag = request.job->redo ? kRecordedRedo : kRecordedUndo;
  const std::uint32_t number = request.job->number;
  if (!restore_.Begin(simulation, *request.job)) return;
  in.flags |= flag;
  in.checkpoint = number;
}

}  // namespace kerf
