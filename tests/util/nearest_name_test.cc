#include "lsmvs/util/nearest_name.h"

#include <gtest/gtest.h>

namespace lsmvs {
namespace {

TEST(NearestName, EditDistance) {
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3);
  EXPECT_EQ(EditDistance("", "abc"), 3);
  EXPECT_EQ(EditDistance("Same", "same"), 0);
}

}  // namespace
}  // namespace lsmvs
