#include <gtest/gtest.h>

#include <cstdio>

#include "device/emulated/emulated_kernel.h"

int main(int argc, char** argv) {
  if (const std::string failure = kerf::test::RunUnderUmockdev(argv); !failure.empty()) {
    std::fprintf(stderr, "%s\n", failure.c_str());
    return 1;
  }
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
