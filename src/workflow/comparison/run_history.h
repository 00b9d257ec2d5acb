#pragma once

#include <map>
#include <string>
#include <vector>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/execution/run_record.h"
#include "lsmvs/report/report.h"

namespace lsmvs {

// The runs that made the meshes of a workspace, from its record.
class RunHistory {
 public:
  // Empty if there is no record.
  explicit RunHistory(const DenseWorkspace& workspace);

  // In the order in which they finished.
  std::vector<ReportStage> Stages() const;
  // Of all stages, by name.
  const std::map<std::string, std::string>& options() const { return options_; }
  // Adds what the tasks took that made the files (names without folder), up to the first one that
  // is not on record.
  void AddCost(const std::vector<std::string>& files, ReportMesh* mesh) const;

 private:
  void Add(const TaskRecord& task);

  std::map<std::string, ReportStage> stages_;
  std::map<std::string, std::string> finished_, options_;
  std::map<std::string, TaskRecord> by_output_;
};

}  // namespace lsmvs
