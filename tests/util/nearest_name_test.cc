#include "lsmvs/util/nearest_name.h"

#include <gtest/gtest.h>

namespace lsmvs {
namespace {

TEST(NearestName, EditDistance) {
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3);
  EXPECT_EQ(EditDistance("", "abc"), 3);
  EXPECT_EQ(EditDistance("Same", "same"), 0);
}

TEST(NearestName, AnExtensionIsNoReasonToSuggestAFile) {
  const std::vector<std::string> photos = {"left.jpg", "right.jpg"};
  EXPECT_EQ(NearestName("righ.jpg", photos), "right.jpg");
  EXPECT_EQ(NearestName("kitchen_0017.jpg", photos), "");
}

TEST(NearestName, OptionsMayBeNamedWithoutTheirGroup) {
  const std::vector<std::string> options = {"Group.max_error", "overwrite"};
  EXPECT_EQ(NearestOption("max_eror", options), "Group.max_error");
  EXPECT_EQ(NearestOption("Other.max_error", options), "Group.max_error");
  EXPECT_EQ(NearestOption("overwrit", options), "overwrite");
  EXPECT_EQ(NearestOption("zzzzzz", options), "");
}

}  // namespace
}  // namespace lsmvs
