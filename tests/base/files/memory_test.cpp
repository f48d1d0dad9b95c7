// Errors when memory runs out.
#include "base/files/memory.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdlib>
#include <new>
#include <optional>

namespace kerf {
namespace {

// More memory than any machine has; volatile, so that the compiler cannot use the value.
volatile std::size_t too_many_bytes = std::size_t{1} << 62;

void RequestTooMuch() {
  ::operator delete(::operator new(too_many_bytes));
}

TEST(ExitOnBadAlloc, EndsTheProgramOnlyWhileAnObjectExists) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer ends the program at such a request";
#endif
  EXPECT_EXIT(
      {
        SetBadAllocHandler([] { std::_Exit(7); });
        EXPECT_THROW(RequestTooMuch(), std::bad_alloc);
        std::optional<ExitOnBadAlloc> first(std::in_place);
        std::optional<ExitOnBadAlloc> second(std::in_place);
        second.reset();
        first.reset();
        EXPECT_THROW(RequestTooMuch(), std::bad_alloc);
        if (::testing::Test::HasFailure()) std::_Exit(1);
        first.emplace();
        second.emplace();
        first.reset();
        RequestTooMuch();
        std::_Exit(0);
      },
      testing::ExitedWithCode(7), "");
}

TEST(ExitOnBadAlloc, KeepsTheExceptionIfNoFunctionIsSet) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer ends the program at such a request";
#endif
  const ExitOnBadAlloc ends;
  EXPECT_THROW(RequestTooMuch(), std::bad_alloc);
}

}  // namespace
}  // namespace kerf
