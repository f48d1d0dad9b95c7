// What a signal does to the program, as src/app/cli/signals.cpp has it.
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

// Each in a process of its own, which says with its exit code that it was not ended.
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

// timeout(1) tells its child of the signal, and then all of the group that the child is in.
TEST(Signals, ToldTwiceAtOnceItIsStillTheFirst) {
  // On a machine that stands still for a quarter of a second between them they are two: then once more.
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

TEST(Signals, ASecondOneEndsTheProgram) {
  EXPECT_EXIT(CatchAnd([] {
                std::raise(SIGINT);
                std::this_thread::sleep_for(std::chrono::milliseconds(300));
                std::raise(SIGINT);
              }),
              testing::KilledBySignal(SIGINT), "");
}

TEST(Signals, AnotherOneEndsTheProgramAtOnce) {
  EXPECT_EXIT(CatchAnd([] {
                std::raise(SIGHUP);
                std::raise(SIGTERM);
              }),
              testing::KilledBySignal(SIGTERM), "");
}

}  // namespace
}  // namespace kerf::cli
