// How progress goes with the time that is spent, stage by stage.

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>

#include "lsmvs/execution/run_plan.h"
#include "lsmvs/execution/run_store.h"
#include "lsmvs/execution/run_tasks.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/synthetic/workspace.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/workflow/planning/run_reconstruction.h"

namespace lsmvs {
namespace {

// Time of the process, so that a busy machine makes no difference.
double CpuSeconds() {
  rusage usage = {};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

struct StageProgress {
  std::string name;
  double begin = 0, end = 0;
  std::vector<std::pair<double, double>> reports;  // time, fraction
};

// Notes the time of every report; work in one thread.
class Recorder : public RunObserver, public ProgressSink {
 public:
  void OnStageBegin(const PlannedStage& stage, double) override {
    stages.push_back({stage.name, CpuSeconds(), 0, {}});
  }
  void OnStageEnd(const StageSummary&) override { stages.back().end = CpuSeconds(); }
  void Report(double fraction) override {
    if (!stages.empty()) stages.back().reports.emplace_back(CpuSeconds(), fraction);
  }

  std::vector<StageProgress> stages;
};

std::vector<StageProgress> RecordRun(const DenseWorkspace& workspace) {
  RunContext context(1);
  StageOptions stage;
  ReconstructionOptions options;
  Recorder recorder;
  context.set_progress(&recorder);
  const CommandContext command{context, nullptr};
  const ReconstructionPtr reconstruction = OpenReconstruction(workspace, stage, options, command);
  const std::vector<Task> tasks = MakeReconstructionTasks(
      reconstruction, ReconstructionStage::kStereo, ReconstructionStage::kRefinement);
  RunStore store(workspace.folder, "test");
  const RunPlan plan = PlanRun(tasks, {}, &store);
  RunTasks(tasks, plan, &store, &recorder, context);
  return recorder.stages;
}

TEST(Progress, IsMonotoneAndGoesWithTheTime) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "times are those of programs without sanitizers";
#endif
  const TemporaryFolder folder;
  SyntheticSceneOptions options;
  options.shape = ShapeName::kRelief;
  options.num_views = 7;
  options.width = 480;
  options.height = 360;
  options.num_sparse_points = 3000;
  SyntheticScene scene = MakeScene(options, RunContext(1));
  WriteWorkspace(folder.path(), WorkspaceFormat::kDense, &scene, RunContext(1));
  const std::vector<StageProgress> stages = RecordRun(DenseWorkspace{folder.path()});
  ASSERT_EQ(stages.size(), 4u);
  for (const StageProgress& stage : stages) {
    const double all = stage.end - stage.begin;
    double before = 0, largest_deviation = 0, largest_jump = 0;
    for (const auto& [time, fraction] : stage.reports) {
      EXPECT_GE(fraction, before) << stage.name;
      largest_jump = std::max(largest_jump, fraction - before);
      before = std::max(before, fraction);
      largest_deviation =
          std::max(largest_deviation, std::abs(fraction - (time - stage.begin) / all));
    }
    ASSERT_FALSE(stage.reports.empty()) << stage.name;
    EXPECT_EQ(stage.reports.back().second, 1.0) << stage.name;
    EXPECT_LT(largest_deviation, 0.25) << stage.name << ", " << all << " s";
    EXPECT_LT(largest_jump, 0.35) << stage.name;
    RecordProperty(stage.name + " deviation", std::to_string(largest_deviation));
    RecordProperty(stage.name + " jump", std::to_string(largest_jump));
  }
}

}  // namespace
}  // namespace lsmvs
