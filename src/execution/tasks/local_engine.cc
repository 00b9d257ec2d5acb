#include "lsmvs/execution/engine.h"
#include "lsmvs/execution/job_order.h"
#include "lsmvs/execution/tasks/task_runner.h"

namespace lsmvs {

namespace {

class LocalEngine : public Engine {
 public:
  std::string name() const override { return "local"; }

  void RunStage(StageWork* work) override {
    root_ = work->store()->root();
    for (size_t i = work->stage().begin; i < work->stage().end; ++i) {
      if (work->plan().tasks[i].state != TaskState::kRun) continue;
      const RunContext context = work->ContextOf(i);
      context.ThrowIfCancelled();
      if (work->Skip(i)) continue;
      RunHere(i, context, work);
      work->OnDone(i);
    }
  }

  // What jobs of an earlier run have left.
  void Finish() override {
    std::error_code ignored;
    if (!root_.empty()) std::filesystem::remove_all(JobsFolder(root_), ignored);
  }

  StageDivision Divide(const std::vector<Task>& /*tasks*/, const RunPlan& /*plan*/,
                       const PlannedStage& /*stage*/) const override {
    return {};
  }

 private:
  static void RunHere(size_t i, const RunContext& context, StageWork* work) {
    const RunPlan& plan = work->plan();
    RunStore& store = *work->store();
    TaskSite site;
    site.root = store.root();
    site.scratch_folder = plan.scratch_folder;
    site.resident_bytes = plan.tasks[i].resident_bytes;
    site.process_bytes = plan.process_bytes;
    site.staged_path = [&](const auto& output) { return store.StagedPath(output); };
    site.check_added = [&](const auto& output) {
      if (!plan.overwrite) CheckReplaceable(output, &store.files());
    };
    const Task& task = work->tasks()[i];
    RunTask(task, HashInputs(task, &store.files()), site, context, [&](FinishedTask done) {
      store.Publish(task.name, done.outputs, std::move(done.record));
    });
  }

  std::filesystem::path root_;
};

}  // namespace

std::unique_ptr<Engine> MakeLocalEngine() { return std::make_unique<LocalEngine>(); }

}  // namespace lsmvs
