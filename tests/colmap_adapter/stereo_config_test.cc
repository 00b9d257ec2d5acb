#include "lsmvs/colmap_adapter/stereo_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lsmvs/adapter_test/corruption.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Sources = PatchMatchProblem::Sources;

class StereoConfigTest : public testing::Test {
 protected:
  std::vector<PatchMatchProblem> Read(const std::string& text) const {
    WriteWholeFile(path_, text);
    return ReadPatchMatchConfig(path_);
  }
  std::string Error(const std::string& text) const {
    return InputErrorOf([&] { Read(text); });
  }

  TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "patch-match.cfg";
};

TEST_F(StereoConfigTest, ReadsEveryKindOfSources) {
  const auto problems = Read(
      "# comment\n\na.jpg\n__auto__, 7\n sub/b c.jpg \n#x\n__all__\r\nd.jpg\na.jpg,  sub/b "
      "c.jpg,\n");
  ASSERT_EQ(problems.size(), 3u);
  EXPECT_EQ(problems[0].reference_name, "a.jpg");
  EXPECT_EQ(problems[0].sources, Sources::kAuto);
  EXPECT_EQ(problems[0].max_num_sources, 7);
  EXPECT_EQ(problems[1].reference_name, "sub/b c.jpg");
  EXPECT_EQ(problems[1].sources, Sources::kAll);
  EXPECT_EQ(problems[2].sources, Sources::kListed);
  EXPECT_THAT(problems[2].source_names, ElementsAre("a.jpg", "sub/b c.jpg"));
}

TEST_F(StereoConfigTest, ReadsWhatItWrote) {
  const std::vector<PatchMatchProblem> problems = {{"a.jpg", Sources::kAuto, 5, {}},
                                                   {"b.jpg", Sources::kAll, 20, {}},
                                                   {"c", Sources::kListed, 20, {"a", "b"}}};
  WritePatchMatchConfig(path_, problems);
  EXPECT_EQ(ReadWholeFile(path_), "a.jpg\n__auto__, 5\nb.jpg\n__all__\nc\na, b\n");
  const auto read = ReadPatchMatchConfig(path_);
  ASSERT_EQ(read.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read[i].reference_name, problems[i].reference_name);
    EXPECT_EQ(read[i].sources, problems[i].sources);
    EXPECT_EQ(read[i].max_num_sources, problems[i].max_num_sources);
    EXPECT_EQ(read[i].source_names, problems[i].source_names);
  }
}

TEST_F(StereoConfigTest, ErrorsNameTheLine) {
  EXPECT_THAT(Error("a.jpg\n"), HasSubstr("'a.jpg' without naming its source images"));
  for (const char* sources :
       {"__auto__", "__auto__, x", "__auto__, 0", "__auto__, -3", "__auto__, 3, 4"}) {
    EXPECT_THAT(Error(std::string("a.jpg\n") + sources + "\n"),
                HasSubstr("line 2: needs a number"));
  }
  EXPECT_THAT(Error("a.jpg\n , ,\n"), HasSubstr("line 2: names no source"));
  EXPECT_THAT(InputErrorOf([&] { ReadPatchMatchConfig(folder_.path() / "none.cfg"); }),
              HasSubstr("none.cfg: cannot be opened"));
  EXPECT_THAT(InputErrorOf([&] { ReadPatchMatchConfig(folder_.path()); }), HasSubstr("as a file"));
}

TEST_F(StereoConfigTest, RulesNameViewsAndRefuseUnknownNames) {
  Scene scene;
  for (const char* name : {"a.jpg", "b c.jpg", "d.jpg"}) {
    scene.views.emplace_back();
    scene.views.back().name = name;
  }
  const auto rules_of = [&](const std::string& text) {
    WriteWholeFile(path_, text);
    return ToSourceRules(ReadPatchMatchConfig(path_), scene, path_);
  };
  const auto rules = rules_of("# by hand\na.jpg\nd.jpg, b c.jpg\nd.jpg\n__auto__, 5\n");
  ASSERT_EQ(rules.size(), 3u);
  EXPECT_EQ(rules[0].kind, SourceRule::Kind::kListed);
  EXPECT_EQ(rules[0].view_idxs, (std::vector<int>{2, 1}));
  EXPECT_EQ(rules[1].kind, SourceRule::Kind::kNone);
  EXPECT_EQ(rules[2].kind, SourceRule::Kind::kBest);
  EXPECT_EQ(rules[2].max_count, 5);
  EXPECT_EQ(rules_of("a.jpg\n__all__\n")[0].kind, SourceRule::Kind::kAll);
  EXPECT_THAT(InputErrorOf([&] { rules_of("a.jpg\n\nd.jpg, e.jpg\n"); }),
              HasSubstr("line 3: the sparse model has no image 'e.jpg'"));
  EXPECT_THAT(InputErrorOf([&] { rules_of("x\n__all__\n"); }),
              HasSubstr("line 1: the sparse model has no image 'x'"));
  EXPECT_THAT(InputErrorOf([&] { rules_of("a.jpg\n__all__\na.jpg\n__all__\n"); }),
              HasSubstr("line 3: 'a.jpg' is a reference for the second time"));
}

TEST_F(StereoConfigTest, ColmapsOwnListIsKnown) {
  EXPECT_TRUE(AreColmapsDefault(Read("a.jpg\n__auto__, 20\nb.jpg\n__auto__, 20\n")));
  EXPECT_FALSE(AreColmapsDefault(Read("a.jpg\n__auto__, 20\nb.jpg\n__auto__, 3\n")));
  EXPECT_FALSE(AreColmapsDefault(Read("a.jpg\n__all__\n")));
}

TEST_F(StereoConfigTest, FusionConfigRoundTrip) {
  const std::vector<std::string> names = {"b.jpg", "sub/a c.jpg"};
  WriteFusionConfig(path_, names);
  EXPECT_EQ(ReadWholeFile(path_), "b.jpg\nsub/a c.jpg\n");
  EXPECT_EQ(ReadFusionConfig(path_), names);
  WriteWholeFile(path_, "#\n\n a.jpg\r\n");
  EXPECT_THAT(ReadFusionConfig(path_), ElementsAre("a.jpg"));
}

TEST_F(StereoConfigTest, MutationsNeverCrash) {
  Read("a.jpg\n__auto__, 7\nb.jpg\na.jpg, c.jpg\n");
  ExpectSurvivesMutations(path_, 500, [&] { ReadPatchMatchConfig(path_); });
  ExpectSurvivesMutations(path_, 100, [&] { ReadFusionConfig(path_); });
}

}  // namespace
}  // namespace lsmvs
