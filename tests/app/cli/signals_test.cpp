// Tests of the program's reactions to signals, which are implemented in src/app/cli/signals.cpp.
#include "app/cli/signals.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

namespace kerf::cli {
namespace {

// Each case runs in a separate process, whose exit code shows that the signal did not end it.
constexpr int kGoesOn = 42;

[[noreturn]] void CatchAnd(void (*raise_signals)()) {
  HandleSignals();
  const std::atomic<bool>& interrupted = CatchInterrupt();
  if (interrupted.load()) std::_Exit(1);
  raise_signals();
  std::_Exit(interrupted.load() ? kGoesOn : 2);
}

TEST(Signals, TheFirstIsNoted) {
  EXPECT_EXIT(CatchAnd([] { std::raise(SIGINT); }), testing::ExitedWithCode(kGoesOn), "");
  EXPECT_EXIT(CatchAnd([] { std::raise(SIGTERM); }), testing::ExitedWithCode(kGoesOn), "");
}

// timeout(1) sends the signal to its child, and then to the whole process group of the child.
TEST(Signals, ImmediateRepetitionCountsAsTheFirstSignal) {
  // If the machine stalls for a quarter of a second between the two signals, they count as separate, and the test is
  // repeated.
  bool was_noted = false;
  for (int tries = 0; tries < 3 && !was_noted; ++tries) {
    EXPECT_EXIT(CatchAnd([] {
                  std::raise(SIGINT);
                  std::raise(SIGINT);
                }),
                ([&](int status) {
                  was_noted = WIFEXITED(status) && WEXITSTATUS(status) == kGoesOn;
                  return was_noted || WIFSIGNALED(status);
                }),
                "");
  }
  EXPECT_TRUE(was_noted);
}

TEST(Signals, SecondSignalEndsTheProgram) {
  EXPECT_EXIT(CatchAnd([] {
                std::raise(SIGINT);
                std::this_thread::sleep_for(std::chrono::milliseconds(300));
                std::raise(SIGINT);
              }),
              testing::KilledBySignal(SIGINT), "");
}

TEST(Signals, DifferentSignalEndsTheProgramImmediately) {
  EXPECT_EXIT(CatchAnd([] {
                std::raise(SIGHUP);
                std::raise(SIGTERM);
              }),
              testing::KilledBySignal(SIGTERM), "");
}

}  // namespace
}  // namespace kerf::cli
