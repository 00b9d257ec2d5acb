#include "lsmvs/workflow/comparison/run_history.h"

#include <algorithm>
#include <filesystem>
#include <sstream>

namespace lsmvs {

namespace fs = std::filesystem;

RunHistory::RunHistory(const DenseWorkspace& workspace) {
  const fs::path path = workspace.RunRecordPath();
  if (!fs::exists(path)) return;
  const RunRecord record = ReadRunRecord(path, workspace.folder);
  for (const auto& [name, task] : record.tasks) Add(task);
}

std::vector<ReportStage> RunHistory::Stages() const {
  std::vector<std::pair<std::string, ReportStage>> sorted;
  for (const auto& [name, stage] : stages_) sorted.emplace_back(finished_.at(name), stage);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<ReportStage> stages;
  for (auto& [time, stage] : sorted) stages.push_back(std::move(stage));
  return stages;
}

void RunHistory::AddCost(const std::vector<std::string>& files, ReportMesh* mesh) const {
  for (const std::string& file : files) {
    const auto found = by_output_.find(file);
    if (found == by_output_.end()) return;
    mesh->seconds = mesh->seconds.value_or(0) + found->second.seconds;
    mesh->peak_bytes = std::max(mesh->peak_bytes.value_or(0), found->second.peak_bytes);
  }
}

void RunHistory::Add(const TaskRecord& task) {
  ReportStage& stage = stages_[task.stage];
  stage.name = task.stage;
  stage.seconds += task.seconds;
  stage.peak_bytes = std::max(stage.peak_bytes.value_or(0), task.peak_bytes);
  finished_[task.stage] = std::max(finished_[task.stage], task.finished);
  for (const std::string& output : task.outputs) {
    by_output_[fs::path(output).filename().string()] = task;
  }
  std::istringstream lines(task.options);
  for (std::string line; std::getline(lines, line);) {
    const size_t split = line.find('=');
    if (split != std::string::npos) options_[line.substr(0, split)] = line.substr(split + 1);
  }
}

}  // namespace lsmvs
