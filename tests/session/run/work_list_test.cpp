#include "session/run/work_list.h"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <thread>

namespace kerf {
namespace {

TEST(WorkList, RunsEachItemOnceAndReportsProgress) {
  WorkList list;
  std::array<std::atomic<int>, 40> done{};
  for (std::size_t i = 0; i < done.size(); ++i)
    list.Add(i < 20 ? "first" : "second", 1 + double(i % 3), [&, i] { ++done[i]; });
  double last = 0;
  bool second = false;
  EXPECT_TRUE(list.Run(3, nullptr, [&](const std::string& stage, double fraction) {
    EXPECT_GE(fraction, last);
    last = fraction;
    second = second || stage == "second";
  }));
  for (const auto& count : done) EXPECT_EQ(count, 1);
  EXPECT_NEAR(last, 1, 1e-12);
  EXPECT_TRUE(second);
}

TEST(WorkList, RethrowsAnItemsExceptionAndStartsNoMoreItems) {
  WorkList list;
  std::atomic<int> done = 0;
  list.Add("", 1, [] { throw std::runtime_error("broken"); });
  for (int i = 0; i < 10; ++i) list.Add("", 1, [&] { ++done; });
  EXPECT_THROW(list.Run(1, nullptr, {}), std::runtime_error);
  EXPECT_EQ(done, 0);
}

TEST(WorkList, WaitsForOtherThreadsWhenProgressThrows) {
  WorkList list;
  std::atomic<int> done = 0;
  std::atomic<bool> thrown = false;
  const std::thread::id mine = std::this_thread::get_id();
  for (int i = 0; i < 10; ++i) {
    list.Add("", 1, [&] {
      thrown.wait(false);
      ++done;
    });
  }
  const auto throws_here = [&](const std::string&, double) {
    if (std::this_thread::get_id() != mine) return;
    thrown = true;
    thrown.notify_all();
    throw std::runtime_error("no memory");
  };
  EXPECT_THROW(list.Run(3, nullptr, throws_here), std::runtime_error);
  EXPECT_EQ(done, 9);  // all except the one that this thread had taken
}

TEST(WorkList, StopsEarlyOnRequest) {
  WorkList list;
  std::atomic<bool> stop = false;
  std::atomic<int> done = 0;
  for (int i = 0; i < 10; ++i) {
    list.Add("", 1, [&] {
      if (++done == 3) stop = true;
    });
  }
  EXPECT_FALSE(list.Run(1, &stop, {}));
  EXPECT_EQ(done, 3);
  EXPECT_TRUE(WorkList().Run(2, nullptr, {}));  // with nothing to do, it is complete at once
}

}  // namespace
}  // namespace kerf
