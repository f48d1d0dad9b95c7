// A folder for results that does not exist at the beginning of a test and is removed after it.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace kerf::test {

class ResultFolderTest : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = (std::filesystem::temp_directory_path() /
               ("kerf_" + std::string(info->test_suite_name()) + "_" + info->name() + "_" + std::to_string(getpid())))
                  .string();
    std::filesystem::remove_all(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string folder_;  // not created yet
};

}  // namespace kerf::test
