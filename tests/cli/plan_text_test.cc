#include "lsmvs/cli/plan_text.h"

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
  plan.stages = {Stage("stereo", 0, 20, 8, {120, size_t{1} << 30}),
                 Stage("fusion", 20, 21, 1, {10, size_t{3} << 30}), Stage("mesh", 21, 22, 0)};
  return plan;
}

PlanHeader MakeHeader() { return {"/w", 10, 12.5e6, 1234567, 2, size_t{4} << 30}; }

TEST(PlanText, SaysWhatIsToDoAndWhatItTakes) {
  const std::string text = PlanText(MakeHeader(), MakePlan());
  EXPECT_THAT(text, AllOf(HasSubstr("10 views"), HasSubstr("12.5 megapixels"),
                          HasSubstr("1,234,567 sparse points"), HasSubstr("4.0 GB of memory")));
  EXPECT_THAT(text, HasSubstr("8 of 20 steps, new"));
  EXPECT_THAT(text, HasSubstr("1:00 min"));  // 120 s of work on two threads
  EXPECT_THAT(text, HasSubstr("up to date"));
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
  header.memory_budget_bytes = size_t{3} << 28;  // a quarter of what fusion needs: half the side
  EXPECT_THAT(Refusal(header, 2400),
              AllOf(HasSubstr("fusion"), HasSubstr("3.0 GB"), HasSubstr("--max_image_size 1200"),
                    HasSubstr("--max_memory")));
  header.memory_budget_bytes = 1;
  EXPECT_THAT(Refusal(header, 2400), AllOf(HasSubstr("fewer photos"), Not(HasSubstr("size 0"))));
}

TEST(CountsText, ShowsTheFiguresThatPeopleKnow) {
  EXPECT_EQ(CountsText({{"points", 1234567}, {"pairs", 3}, {"faces", 999}}),
            "1,234,567 points, 999 faces");
  EXPECT_EQ(CountsText({}), "");
}

}  // namespace
}  // namespace lsmvs
