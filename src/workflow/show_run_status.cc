#include "lsmvs/workflow/show_run_status.h"

#include <fmt/format.h>

#include <ctime>
#include <filesystem>
#include <map>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/execution/run_status.h"
#include "lsmvs/execution/run_store.h"
#include "lsmvs/util/duration_text.h"

namespace lsmvs {

namespace {

// A run writes its status every few seconds.
constexpr int64_t kSilentSeconds = 120;

std::string JobsText(const JobCounts& jobs) {
  if (jobs.waiting + jobs.running == 0) return "";
  std::string text = fmt::format("\n  jobs: {} running", jobs.running);
  if (!jobs.nodes.empty()) text += fmt::format(" on {}", jobs.nodes);
  text += fmt::format(", {} waiting", jobs.waiting);
  if (jobs.waiting > 0 && !jobs.reason.empty()) text += fmt::format(" ({})", jobs.reason);
  return text;
}

std::string StatusText(const RunStatus& status, int64_t now) {
  std::string text = fmt::format("  {}: {:.0f} %, {} of {} steps, {} so far", status.stage,
                                 100 * status.fraction, status.num_done, status.num_tasks,
                                 FormatSeconds(static_cast<double>(now - status.began)));
  const double done = status.fraction - status.fraction_before;
  if (done > 0.01) {
    const double left =
        static_cast<double>(status.updated - status.began) * (1 - status.fraction) / done;
    text += fmt::format(", about {} left of this stage", FormatSeconds(left));
  }
  text += JobsText(status.jobs);
  text +=
      fmt::format("\n  engine {}, process {} on {}", status.engine, status.process_id, status.host);
  if (now - status.updated > kSilentSeconds) {
    text += fmt::format(
        "\n  nothing was heard of it for {}: it was killed, or its machine does not "
        "answer; start the same command again to go on",
        FormatSeconds(static_cast<double>(now - status.updated)));
  }
  return text + "\n";
}

// Stages on record.
std::string RecordText(const RunRecord& record) {
  std::map<std::string, std::pair<size_t, double>> stages;
  for (const auto& [name, task] : record.tasks) {
    ++stages[task.stage].first;
    stages[task.stage].second += task.cpu_seconds;
  }
  std::string text;
  for (const auto& [stage, sums] : stages) {
    text += fmt::format("  {}: {} steps on record, {} of CPU\n", stage, sums.first,
                        FormatSeconds(sums.second));
  }
  return text.empty() ? "  nothing is on record\n" : text;
}

}  // namespace

void RunStatusOptions::Describe(OptionSet* options) {
  options->Add("workspace_path", &workspace_path, "Dense workspace, or a project with several.");
}

void ShowRunStatus(const RunStatusOptions& options, const CommandContext& context) {
  for (const WorkspaceEntry& entry : FindDenseWorkspaces(options.workspace_path)) {
    if (!entry.exists) continue;
    const std::filesystem::path root = entry.workspace.folder;
    const std::optional<RunStatus> status = ReadRunStatus(root);
    context.console->Print(
        fmt::format("{}\n{}{}", root.string(),
                    status ? StatusText(*status, std::time(nullptr)) : "  no run is at work\n",
                    RecordText(ReadRecordOf(root))));
  }
}

}  // namespace lsmvs
