#include "lsmvs/util/checkpoint_folder.h"

#include <gtest/gtest.h>

#include <numeric>

#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

TEST(CheckpointFolder, GivesBackWhatWasWritten) {
  const TemporaryFolder folder;
  const CheckpointFolder checkpoints(folder.path() / "steps");
  std::vector<uint64_t> values(300000);
  std::iota(values.begin(), values.end(), uint64_t{7});
  EXPECT_FALSE(checkpoints.HasFinished("a"));
  checkpoints.Write("values", values);
  checkpoints.Write("none", std::vector<float>());
  EXPECT_FALSE(checkpoints.HasFinished("a"));
  checkpoints.FinishStep("a");
  EXPECT_TRUE(checkpoints.HasFinished("a"));
  EXPECT_FALSE(checkpoints.HasFinished("b"));
  std::vector<uint64_t> read = {1, 2, 3};
  checkpoints.Read("values", &read);
  EXPECT_EQ(read, values);
  std::vector<float> none = {1};
  checkpoints.Read("none", &none);
  EXPECT_TRUE(none.empty());
}

TEST(CheckpointFolder, RefusesWhatIsMissingOrCutOff) {
  const TemporaryFolder folder;
  const CheckpointFolder checkpoints(folder.path());
  std::vector<uint64_t> read;
  EXPECT_THROW(checkpoints.Read("values", &read), InputError);
  checkpoints.Write("values", std::vector<uint64_t>{1, 2, 3});
  std::filesystem::resize_file(folder.path() / "values", 13);
  EXPECT_THROW(checkpoints.Read("values", &read), InputError);
}

TEST(CheckpointFolder, WithoutAFolderNothingIsKept) {
  const CheckpointFolder checkpoints;
  EXPECT_FALSE(checkpoints.is_on());
  EXPECT_NO_THROW(checkpoints.Write("values", std::vector<int>{1}));
  EXPECT_NO_THROW(checkpoints.FinishStep("a"));
  EXPECT_FALSE(checkpoints.HasFinished("a"));
}

}  // namespace
}  // namespace lsmvs
