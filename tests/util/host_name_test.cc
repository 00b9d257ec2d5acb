#include "lsmvs/util/host_name.h"

#include <gtest/gtest.h>

#include <fstream>

namespace lsmvs {
namespace {

TEST(HostName, IsWhatTheKernelSays) {
  std::ifstream file("/proc/sys/kernel/hostname");
  std::string name;
  ASSERT_TRUE(file >> name);
  EXPECT_EQ(HostName(), name);
}

}  // namespace
}  // namespace lsmvs
