#include "lsmvs/workflow/planning/plan_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

PlannedStage Stage(const std::string& name, size_t begin, size_t end, size_t num_run,
                   const CostEstimate& cost = {}) {
  PlannedStage stage;
  stage.name = name;
  stage.begin = begin;
  stage.end = end;
  stage.num_run = num_run;
  stage.num_up_to_date = end - begin - num_run;
  stage.reason = num_run > 0 ? "new" : "";
  stage.cost = cost;
  return stage;
}

RunPlan MakePlan() {
  RunPlan plan;
  plan.stages = {Stage("stereo", 0, 20, 8, {120, 1'000'000'000}),
                 Stage("fusion", 20, 21, 1, {10, 3'000'000'000}), Stage("mesh", 21, 22, 0)};
  plan.stages[0].output_bytes = 7'000'000'000;
  plan.peak_disk_bytes = 8'000'000'000;
  return plan;
}

PlanHeader MakeHeader() {
  return {"/w", 10, 12.5e6, 1234567, 2, 100'000'000, 4'000'000'000, false, {}, {}};
}

TEST(PlanText, SaysWhatIsToDoAndWhatItTakes) {
  const std::string text = PlanText(MakeHeader(), MakePlan());
  EXPECT_THAT(text, AllOf(HasSubstr("10 views"), HasSubstr("12.5 megapixels"),
                          HasSubstr("1,234,567 sparse points"), HasSubstr("4.0 GB of memory")));
  EXPECT_THAT(text, HasSubstr("8 of 20 steps, new"));
  EXPECT_THAT(text, HasSubstr("1:00 min"));  // 120 s of work on two threads
  EXPECT_THAT(text, HasSubstr("up to date"));
  // Memory is that of the whole process.
  EXPECT_THAT(text, AllOf(HasSubstr("1.1 GB"), HasSubstr("3.1 GB")));
  EXPECT_THAT(text, AllOf(HasSubstr("7.0 GB"), HasSubstr("8.0 GB")));
}

TEST(PlanText, ForeignAndUnneededStagesAreNamedSo) {
  RunPlan plan = MakePlan();
  plan.stages[1].num_run = 0;
  plan.stages[1].num_foreign = 1;
  plan.stages[2].num_up_to_date = 0;
  const std::string text = PlanText(MakeHeader(), plan);
  EXPECT_THAT(text, HasSubstr("used as it is"));
  EXPECT_THAT(text, HasSubstr("not needed"));
}

TEST(PlanText, NothingToDo) {
  RunPlan plan;
  plan.stages = {Stage("mesh", 0, 1, 0)};
  EXPECT_THAT(PlanText(MakeHeader(), plan), HasSubstr("everything is up to date"));
}

std::string Refusal(const PlanHeader& header, int image_size) {
  try {
    CheckPlanFits(header, MakePlan(), image_size);
  } catch (const MemoryError& error) {
    return error.what();
  }
  return "";
}

TEST(CheckPlanFits, NamesTheStageAndASizeThatFits) {
  PlanHeader header = MakeHeader();
  EXPECT_EQ(Refusal(header, 2400), "");
  header.memory_allowed_bytes = 3'100'000'000;
  EXPECT_EQ(Refusal(header, 2400), "");
  // Beyond the process itself a quarter of what fusion needs: half the side.
  header.memory_allowed_bytes = 100'000'000 + 750'000'000;
  EXPECT_THAT(Refusal(header, 2400),
              AllOf(HasSubstr("fusion"), HasSubstr("3.1 GB"), HasSubstr("--max_image_size 1200"),
                    HasSubstr("--max_memory")));
  header.memory_allowed_bytes = 1;
  EXPECT_THAT(Refusal(header, 2400), AllOf(HasSubstr("fewer photos"), Not(HasSubstr("size 0"))));
}

// The mesher has no photos to make smaller.
TEST(CheckPlanFits, AdvisesASurfaceAloneOnItsOwnOptions) {
  PlanHeader header = MakeHeader();
  header.memory_allowed_bytes = 850'000'000;
  RunPlan plan;
  plan.stages = {Stage("visibility_mesher", 0, 1, 1, {10, 3'000'000'000})};
  try {
    CheckPlanFits(header, plan, 2400);
    FAIL() << "it is not refused";
  } catch (const MemoryError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("--bounding_box"), HasSubstr("max_proj_dist"),
                                    HasSubstr("--max_memory"), Not(HasSubstr("max_image_size"))));
  }
}

TEST(CheckPlanFitsDisk, NamesWhatIsFreeAndASizeThatFits) {
  const PlanHeader header = MakeHeader();
  EXPECT_NO_THROW(CheckPlanFitsDisk(header, MakePlan(), 8'000'000'000, 2400));
  try {
    CheckPlanFitsDisk(header, MakePlan(), 2'000'000'000, 2400);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kFileSystem);
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("/w"), HasSubstr("8.0 GB"), HasSubstr("2.0 GB are free"),
                      HasSubstr("--max_image_size 1200"), HasSubstr("--ignore_disk_space")));
  }
}

RunPlan PlanWithScratch() {
  RunPlan plan = MakePlan();
  plan.stages[1].scratch_bytes = plan.peak_scratch_bytes = 12'000'000'000;
  plan.scratch_folder = std::filesystem::temp_directory_path();
  return plan;
}

TEST(PlanText, NamesPartsAndScratchFile) {
  const std::string text = PlanText(MakeHeader(), PlanWithScratch());
  EXPECT_THAT(text, AllOf(HasSubstr("in 4 parts, with a scratch file of 12 GB"),
                          HasSubstr(std::filesystem::temp_directory_path().string())));
  EXPECT_THAT(PlanText(MakeHeader(), MakePlan()), Not(HasSubstr("scratch")));
}

TEST(CheckScratchFits, NamesTheFolderAndWhatHelps) {
  RunPlan plan = PlanWithScratch();
  EXPECT_NO_THROW(CheckScratchFits(MakeHeader(), MakePlan(), Disk{}));
  plan.peak_scratch_bytes = uint64_t{1} << 60;
  try {
    CheckScratchFits(MakeHeader(), plan, Disk{});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kFileSystem);
    EXPECT_THAT(error.what(), AllOf(HasSubstr(plan.scratch_folder.string()),
                                    HasSubstr("--scratch_path"), HasSubstr("--max_memory")));
  }
}

// Two disks may have the same number of bytes free.
TEST(CheckScratchFits, CountsTheResultsOnTheSameDiskOnly) {
  RunPlan plan = PlanWithScratch();
  const std::optional<Disk> disk = DiskOf(plan.scratch_folder);
  ASSERT_TRUE(disk.has_value());
  plan.peak_scratch_bytes = disk->free_bytes / 2;
  plan.peak_disk_bytes = uint64_t{1} << 60;
  const Disk other = {disk->device + 1, disk->free_bytes};
  EXPECT_NO_THROW(CheckScratchFits(MakeHeader(), plan, other));
  EXPECT_NO_THROW(CheckScratchFits(MakeHeader(), plan, std::nullopt));
  EXPECT_THROW(CheckScratchFits(MakeHeader(), plan, Disk{disk->device, 0}), Error);
}

TEST(FindDisk, IsThatWhereTheFirstTaskWrites) {
  Task task;
  task.outputs = {std::filesystem::temp_directory_path() / "not/there/yet/x"};
  RunPlan plan;
  plan.tasks = {{TaskState::kRun, "new"}};
  const std::optional<Disk> disk = FindDisk({task}, plan);
  ASSERT_TRUE(disk.has_value());
  const auto space = std::filesystem::space(std::filesystem::temp_directory_path());
  EXPECT_GT(disk->free_bytes, 0u);
  EXPECT_LE(disk->free_bytes, space.capacity);
  EXPECT_EQ(disk->device, DiskOf(std::filesystem::temp_directory_path())->device);
  plan.tasks[0].state = TaskState::kUpToDate;
  EXPECT_FALSE(FindDisk({task}, plan).has_value());
}

TEST(NeighborNotes, SayWhichPhotosHaveFewNeighboursAndWhy) {
  Scene scene;
  for (int v = 0; v < 10; ++v) {
    scene.views.push_back({});
    scene.views.back().name = std::to_string(v) + ".jpg";
  }
  const Neighbor shared{1, 1.0, 10.0, 50, false}, overlap{1, 1.0, 10.0, 0, true};
  std::vector<std::vector<Neighbor>> neighbors(10, {shared, shared});
  EXPECT_TRUE(NeighborNotes(scene, neighbors).empty());
  neighbors[0] = {};
  neighbors[1] = {shared};
  neighbors[2] = {shared, overlap};
  for (size_t v = 3; v < 10; ++v) neighbors[v] = {overlap, overlap};
  const auto notes = NeighborNotes(scene, neighbors);
  ASSERT_EQ(notes.size(), 3u);
  EXPECT_THAT(notes[0],
              AllOf(HasSubstr("1 photo without"), HasSubstr("0.jpg"), HasSubstr("angle")));
  EXPECT_THAT(notes[1], AllOf(HasSubstr("1 photo with a single"), HasSubstr("1.jpg")));
  EXPECT_THAT(notes[2], AllOf(HasSubstr("7 photos"), HasSubstr("sparse points"),
                              HasSubstr("7.jpg, ..."), Not(HasSubstr("8.jpg"))));
  PlanHeader header = MakeHeader();
  header.notes = notes;
  EXPECT_THAT(PlanText(header, MakePlan()), HasSubstr(notes[2]));
}

TEST(CountsText, ShowsTheFiguresThatPeopleKnow) {
  EXPECT_EQ(CountsText({{"points", 1234567}, {"pairs", 3}, {"faces", 999}}),
            "1,234,567 points, 999 faces");
  EXPECT_EQ(CountsText({}), "");
}

}  // namespace
}  // namespace lsmvs
