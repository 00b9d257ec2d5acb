#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "lsmvs/execution/run_tasks.h"

namespace lsmvs {

inline std::string ReadText(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

inline void WriteText(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path) << text;
}

// Writes "<options>(<inputs>)#<position>" to each output; counts its calls in `calls`.
inline Task TextTask(const std::string& name, const std::vector<std::filesystem::path>& inputs,
                     const std::vector<std::filesystem::path>& outputs, int* calls = nullptr) {
  Task task;
  task.stage = task.name = name;
  task.version = "1";
  task.options = "word=";
  task.options.append(name).append("\n");
  task.inputs = inputs;
  task.outputs = outputs;
  task.run = [=, options = task.options](const TaskRun& run) {
    if (calls != nullptr) ++*calls;
    for (size_t i = 0; i < run.outputs.size(); ++i) {
      std::string text = options.substr(5, options.size() - 6) + "(";
      for (const auto& input : inputs) text += ReadText(input);
      text.append(")#").append(std::to_string(i));
      WriteText(run.outputs[i], text);
    }
    return TaskCounts{{"files", static_cast<double>(run.outputs.size())}};
  };
  return task;
}

class SilentObserver : public RunObserver {
 public:
  void OnStageBegin(const PlannedStage& stage, double fraction_done) override {
    begun.push_back(stage.name);
    done_before.push_back(fraction_done);
  }
  void OnStageEnd(const StageSummary& summary) override { ended.push_back(summary); }

  std::vector<std::string> begun;
  std::vector<double> done_before;
  std::vector<StageSummary> ended;
};

}  // namespace lsmvs
