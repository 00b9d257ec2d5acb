#include "lsmvs/util/option_set.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

enum class Fruit { kApple, kPear };

struct SampleOptions {
  bool flag = true;
  int count = 3;
  double share = 0.25;
  double free = 0.0;
  std::string name = "x";
  std::optional<int> limit;
  std::optional<double> scale;
  Fruit fruit = Fruit::kPear;

  void Describe(OptionSet* options) {
    options->Add("Sample.flag", &flag, "a flag");
    options->Add("Sample.count", &count, "a count", {1, 10});
    options->Add("Sample.share", &share, "a share", {0.0, 1.0});
    options->Add("Sample.free", &free, "any number");
    options->Add("Sample.name", &name, "a name");
    options->Add("Sample.limit", &limit, "a limit", {0, 5});
    options->Add("Sample.scale", &scale, "a scale", {0.5, std::numeric_limits<double>::max()});
    options->AddEnum("Sample.fruit", &fruit, "a fruit",
                     {{"apple", Fruit::kApple}, {"pear", Fruit::kPear}});
  }
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

class OptionSetTest : public ::testing::Test {
 protected:
  OptionSetTest() { options_.Describe(&set_); }
  void Set(const std::string& name, const std::string& text) {
    set_.Find("Sample." + name)->set(text);
  }
  // The message of the error that setting must give.
  std::string Refused(const std::string& name, const std::string& text) {
    try {
      Set(name, text);
    } catch (const UsageError& error) {
      return error.what();
    }
    ADD_FAILURE() << name << " took '" << text << "'";
    return "";
  }
  SampleOptions options_;
  OptionSet set_;
};

TEST_F(OptionSetTest, DescribesTypeBoundsAndDefault) {
  const OptionSet::Entry* count = set_.Find("Sample.count");
  ASSERT_NE(count, nullptr);
  EXPECT_EQ(count->type, "INT");
  EXPECT_EQ(count->bounds, "[1, 10]");
  EXPECT_EQ(count->default_value, "3");
  EXPECT_EQ(set_.Find("Sample.scale")->bounds, ">= 0.5");
  EXPECT_EQ(set_.Find("Sample.scale")->default_value, "");
  EXPECT_EQ(set_.Find("Sample.fruit")->type, "apple|pear");
  EXPECT_EQ(set_.Find("Sample.fruit")->default_value, "pear");
  EXPECT_EQ(set_.Find("Sample.free")->bounds, "");
  EXPECT_EQ(set_.Find("count"), nullptr);
}

TEST_F(OptionSetTest, SetsEveryType) {
  Set("flag", "false");
  Set("count", "7");
  Set("share", "1e-3");
  Set("free", "-12.5");
  Set("name", "a b = c");
  Set("limit", "5");
  Set("scale", "2");
  Set("fruit", "apple");
  EXPECT_FALSE(options_.flag);
  EXPECT_EQ(options_.count, 7);
  EXPECT_EQ(options_.share, 1e-3);
  EXPECT_EQ(options_.free, -12.5);
  EXPECT_EQ(options_.name, "a b = c");
  EXPECT_EQ(options_.limit, 5);
  EXPECT_EQ(options_.scale, 2.0);
  EXPECT_EQ(options_.fruit, Fruit::kApple);
  Set("limit", "");
  EXPECT_FALSE(options_.limit.has_value());
}

TEST_F(OptionSetTest, RefusesWhatIsNotOfTheTypeAndKeepsTheOldValue) {
  for (const char* text : {"", "x", "1.5", "3x", " 3", "99999999999"}) Refused("count", text);
  for (const char* text : {"", "x", "0.5.1", "0,5", "1e999"}) Refused("share", text);
  for (const char* text : {"", "2", "ja"}) Refused("flag", text);
  for (const char* text : {"", "plum", "Apple"}) Refused("fruit", text);
  EXPECT_EQ(options_.count, 3);
  EXPECT_EQ(options_.share, 0.25);
  EXPECT_TRUE(options_.flag);
  EXPECT_NE(Refused("fruit", "plum").find("apple, pear"), std::string::npos);
}

TEST_F(OptionSetTest, RefusesValuesOutsideTheirBoundsByName) {
  for (const char* text : {"0", "11", "-1"}) {
    const std::string message = Refused("count", text);
    EXPECT_NE(message.find("--Sample.count"), std::string::npos) << message;
    EXPECT_NE(message.find(text), std::string::npos) << message;
    EXPECT_NE(message.find("[1, 10]"), std::string::npos) << message;
  }
  Refused("limit", "6");
  Refused("scale", "0.4");
  Refused("share", "nan");
  for (const char* text : {"inf", "-inf", "nan"}) {
    const std::string message = Refused("free", text);
    EXPECT_NE(message.find("must be a finite number"), std::string::npos) << message;
  }
  for (const char* text : {"1", "10"}) Set("count", text);
}

TEST_F(OptionSetTest, CheckFindsValuesSetInCode) {
  std::string error;
  EXPECT_TRUE(options_.Check(&error)) << error;
  options_.share = std::nan("");
  EXPECT_FALSE(options_.Check(&error));
  EXPECT_NE(error.find("Sample.share"), std::string::npos);
  EXPECT_FALSE(options_.Check(nullptr));
  options_.share = 1.0;
  options_.limit = 6;
  EXPECT_FALSE(options_.Check(&error));
  EXPECT_NE(error.find("Sample.limit"), std::string::npos);
  options_.limit.reset();
  options_.fruit = static_cast<Fruit>(9);
  EXPECT_FALSE(options_.Check(&error));
  EXPECT_NE(error.find("Sample.fruit"), std::string::npos);
}

TEST_F(OptionSetTest, TextChangesWithEveryValueAndReadsBack) {
  const std::string before = set_.ToText();
  options_.share = 0.1 + 0.2;  // not 0.3
  const std::string after = set_.ToText();
  EXPECT_NE(before, after);
  EXPECT_NE(after.find("Sample.share=0.30000000000000004\n"), std::string::npos) << after;
  Set("share", set_.Find("Sample.share")->get());
  EXPECT_EQ(options_.share, 0.1 + 0.2);
}

TEST(OptionSetLists, CommasSeparateAndReplace) {
  std::vector<std::string> names = {"old"};
  OptionSet set;
  set.AddCommaList("names", &names, "some names");
  const OptionSet::Entry& entry = *set.Find("names");
  EXPECT_EQ(entry.default_value, "old");
  EXPECT_FALSE(entry.is_list());  // one value holds them all
  entry.set("a.jpg,b c.jpg");
  EXPECT_EQ(names, (std::vector<std::string>{"a.jpg", "b c.jpg"}));
  EXPECT_EQ(entry.get(), "a.jpg,b c.jpg");
  entry.set("");
  EXPECT_TRUE(names.empty());
}

TEST(OptionSetBoxes, ReadBackExactlyAndRefuseWhatIsNone) {
  Eigen::AlignedBox3d box;
  OptionSet set;
  set.Add("box", &box, "a region");
  const OptionSet::Entry& entry = *set.Find("box");
  EXPECT_EQ(entry.default_value, "");
  entry.set("-1,0 0,0.1, 2,3.5");
  EXPECT_EQ(box.min(), Eigen::Vector3d(-1, 0, 0));
  EXPECT_EQ(box.max(), Eigen::Vector3d(0.1, 2, 3.5));
  const Eigen::AlignedBox3d before = box;
  entry.set(entry.get());
  EXPECT_TRUE(box.isApprox(before, 0));
  for (const char* bad :
       {"1,2,3", "0,0,0,1,1,x", "1,0,0,0,1,1", "0,0,0,1,1,1,1", "0,0,0,1,1,inf"}) {
    EXPECT_THROW(entry.set(bad), UsageError) << bad;
  }
  entry.set("");
  EXPECT_TRUE(box.isEmpty());
}

TEST_F(OptionSetTest, RareOptionsMustBeThere) {
  const std::string name = set_.entries().front().name;
  set_.MarkRare({name});
  EXPECT_TRUE(set_.Find(name)->is_rare);
  EXPECT_FALSE(set_.entries().back().is_rare);
  EXPECT_THROW(set_.MarkRare({"there_is_none"}), std::logic_error);
}

TEST_F(OptionSetTest, SameNameTwiceIsAMistake) {
  EXPECT_THROW(options_.Describe(&set_), std::logic_error);
}

}  // namespace
}  // namespace lsmvs
