#include "loop/haptics/restore_exchange.h"

namespace kerf {

RestoreEvent RestoreExchange::Begin(CoupledSimulation& simulation, bool wait) {
  if (wait || restore_.running()) return {};
  const Request* next = ring_.Peek();
  if (next == nullptr) return {};
  const Request request = *next;
  if (request.job == nullptr) {
    if (!simulation.Checkpoint(request.checkpoint)) return {};
    ring_.Pop();
    return {RestoreEvent::Kind::kCheckpoint, request.checkpoint};
  }
  ring_.Pop();
  // The event is copied first, since the job may be destroyed as soon as its refusal is reported.
  const RestoreEvent event{request.job->redo ? RestoreEvent::Kind::kRedo : RestoreEvent::Kind::kUndo,
                           request.job->number};
  return restore_.Begin(simulation, *request.job) ? event : RestoreEvent{};
}

}  // namespace kerf
