// A failing child process never ends the program: the caller gets the child's result or a one-sentence error.
#include "base/files/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/core/cancelled.h"
#include "kerf/error.h"
#include "support/folder.h"

namespace kerf {
namespace {

std::string InChild(const std::function<std::string(ChildReport&)>& work, const ChildLimits& limits = {},
                    const std::function<void(double)>& progress = {}) {
  return RunInChild("scan.dcm", limits, work, progress);
}

std::string Refusal(const std::function<std::string(ChildReport&)>& work, const ChildLimits& limits = {}) {
  return test::MessageOf([&] { InChild(work, limits); }, "nothing was refused");
}

std::size_t CountOpenFiles() {
  const std::filesystem::directory_iterator files("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

TEST(Child, GivesBackEveryByte) {
  std::string bytes(3'000'001, '\0');
  std::uint32_t state = 1;
  for (char& c : bytes) c = static_cast<char>((state = state * 1664525u + 1013904223u) >> 24);
  EXPECT_EQ(InChild([&bytes](ChildReport&) { return bytes; }), bytes);
  EXPECT_EQ(InChild([](ChildReport&) { return std::string(); }), "");
}

TEST(Child, ChangesNothingInThisProcess) {
  int here = 1;
  InChild([&here](ChildReport&) {
    here = 2;
    return std::string();
  });
  EXPECT_EQ(here, 1);
}

TEST(Child, ForwardsProgressInOrder) {
  std::vector<double> seen;
  InChild(
      [](ChildReport& report) {
        for (int i = 1; i <= 1000; ++i) report.SetProgress(i / 1000.0);
        return std::string();
      },
      {}, [&seen](double part) { seen.push_back(part); });
  ASSERT_FALSE(seen.empty());
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_EQ(seen.back(), 1);
}

TEST(Child, ForwardsErrorsUnchanged) {
  EXPECT_EQ(Refusal([](ChildReport&) -> std::string { throw Error("scan.dcm: no bone"); }), "scan.dcm: no bone");
}

TEST(Child, SignalIsReportedWithTheFileName) {
  for (const int signal : {SIGABRT, SIGSEGV, SIGFPE, SIGKILL}) {
    const std::string said = Refusal([signal](ChildReport& report) {
      report.SetName("folder/slice_7.dcm");
      raise(signal);
      return std::string();
    });
    EXPECT_EQ(said.rfind("folder/slice_7.dcm: the file is damaged: the library that reads it failed (", 0), 0u) << said;
  }
}

TEST(Child, OtherExceptionsAreReportedInOneSentence) {
  EXPECT_EQ(Refusal([](ChildReport&) -> std::string { throw std::out_of_range("at"); }),
            "scan.dcm: the file is damaged: the library that reads it failed (at)");
  EXPECT_EQ(Refusal([](ChildReport&) -> std::string { throw 7; }),
            "scan.dcm: the file is damaged: the library that reads it failed");
  for (const int code : {0, 1, 2, 9}) {
    EXPECT_EQ(Refusal([code](ChildReport&) -> std::string { std::exit(code); }),
              "scan.dcm: the file is damaged: the library that reads it failed");
  }
  std::set_terminate([] { _exit(1); });  // a program's own terminate handler may exit like this
  EXPECT_EQ(Refusal([](ChildReport&) -> std::string { std::terminate(); }),
            "scan.dcm: the file is damaged: the library that reads it failed (Aborted)");
  std::set_terminate(nullptr);
}

TEST(Child, ExcessiveMemoryIsRefused) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's shadow memory leaves no room for a limit";
#endif
  const auto ask = [](ChildReport&) {
    std::vector<char> much(std::size_t{512} << 20, 1);
    return std::string(1, much.back());
  };
  EXPECT_EQ(Refusal(ask, {std::uint64_t{256} << 20, 120}),
            "scan.dcm: reading needs more than 256 MiB of memory; the file is too large or damaged");
  EXPECT_EQ(InChild(ask), std::string(1, 1));
}

TEST(Child, ChildWithoutProgressIsKilled) {
  const auto hang = [](ChildReport&) -> std::string {
    for (;;) pause();
  };
  EXPECT_EQ(Refusal(hang, {std::uint64_t{1} << 30, 0.2}),
            "scan.dcm: reading made no progress for 0.2 s and was stopped; the file is damaged");
}

TEST(Child, AllowsOnlyReading) {
  const test::Folder folder;
  const std::string there = folder.path() + "/there";
  test::WriteBytes(there, "bone");
  const std::string said = InChild([&](ChildReport&) -> std::string {
    if (prctl(PR_GET_SECCOMP) == 0) return "no filter";
    const auto refused = [](long result) { return result < 0 && errno == EPERM ? '1' : '0'; };
    std::string all;
    all += refused(open((folder.path() + "/new").c_str(), O_WRONLY | O_CREAT, 0600));
    all += refused(open(there.c_str(), O_RDWR));
    all += refused(syscall(SYS_open, there.c_str(), O_WRONLY | O_TRUNC));
    all += refused(unlink(there.c_str()));
    all += refused(rename(there.c_str(), (folder.path() + "/elsewhere").c_str()));
    all += refused(mkdir((folder.path() + "/folder").c_str(), 0700));
    all += refused(socket(AF_INET, SOCK_STREAM, 0));
    all += refused(fork());
    all += refused(execl("/bin/true", "true", nullptr));
    all += refused(kill(getppid(), 0));
    const int in = open(there.c_str(), O_RDONLY);
    char bytes[4] = {};
    all += in >= 0 && read(in, bytes, 4) == 4 && std::string(bytes, 4) == "bone" ? '1' : '0';
    return all;
  });
  if (said == "no filter") GTEST_SKIP() << "this system has no seccomp filter";
  EXPECT_EQ(said, "11111111111");
  EXPECT_EQ(test::ReadBytes(there), "bone");
}

TEST(Child, NestedWorkRunsInTheSameChild) {
  const std::string pids = InChild([](ChildReport&) {
    const std::string outer = std::to_string(getpid());
    return outer + InChild([](ChildReport&) { return fmt::format(" {}", getpid()); });
  });
  const std::string pid = pids.substr(0, pids.find(' '));
  EXPECT_EQ(pids, pid + " " + pid);
  EXPECT_NE(pid, std::to_string(getpid()));
}

TEST(Child, LeavesNoProcessAndNoOpenFile) {
  const std::size_t before = CountOpenFiles();
  InChild([](ChildReport&) { return std::string("x"); });
  Refusal([](ChildReport&) -> std::string { std::abort(); });
  const auto cancel = [](ChildReport& report) -> std::string {
    report.SetProgress(0.5);
    for (;;) pause();
  };
  EXPECT_THROW(InChild(cancel, {}, [](double) { throw std::runtime_error("cancelled"); }), std::runtime_error);
  EXPECT_EQ(CountOpenFiles(), before);
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

TEST(Child, IsKilledWhenTheWorkIsCancelledEvenIfItIsSilent) {
  pid_t child = 0;
  int calls = 0;
  const SharedMemory shared(sizeof child);
  const auto work = [&shared](ChildReport&) {
    const pid_t self = getpid();
    std::memcpy(shared.data(), &self, sizeof self);
    sleep(600);
    return std::string();
  };
  // Called although the child reports nothing.
  const auto progress = [&calls](double fraction) {
    EXPECT_EQ(fraction, 0);
    if (++calls == 3) throw Cancelled();
  };
  EXPECT_THROW(InChild(work, {}, progress), Cancelled);
  std::memcpy(&child, shared.data(), sizeof child);
  EXPECT_EQ(kill(child, 0), -1);
  EXPECT_EQ(errno, ESRCH);
}

}  // namespace
}  // namespace kerf
