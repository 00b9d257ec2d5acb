#include "job_tasks.h"

#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

#include "lsmvs/util/error.h"
#include "text_tasks.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

std::vector<std::string> ReadLines(const fs::path& path) {
  std::vector<std::string> lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

// The next hook of the task, which is taken off.
std::string TakeHook(const fs::path& root, const std::string& task) {
  const fs::path path = root / "hooks" / task;
  std::vector<std::string> lines = ReadLines(path);
  if (lines.empty()) return "";
  const std::string hook = lines.front();
  std::ofstream file(path);
  for (size_t i = 1; i < lines.size(); ++i) file << lines[i] << "\n";
  return hook;
}

void Sleep(double seconds, const RunContext& context) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    context.ThrowIfCancelled();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

// Touches the memory, and holds it until somebody looks.
void Hold(size_t num_bytes, const RunContext& context) {
  const std::string block(num_bytes, 'x');
  Sleep(block.find('y') == std::string::npos ? 6 : 0, context);
}

void Obey(const std::string& hook, const fs::path& root, const RunContext& context) {
  std::istringstream words(hook);
  std::string verb;
  words >> verb;
  double number = 0;
  words >> number;
  if (verb == "crash") ::kill(::getpid(), SIGKILL);
  if (verb == "sleep") Sleep(number, context);
  if (verb == "hold") Hold(static_cast<size_t>(number), context);
  if (verb == "wrong") throw InputError((root / "photo").string(), "is dark", "take another");
  if (verb == "memory" && context.memory_budget_bytes < static_cast<size_t>(number)) {
    throw MemoryError("does not fit");
  }
  if (verb == "change") WriteText(root / "photo", "dusk");
}

Task MakeJobTask(const fs::path& root, const std::string& stage, const std::string& name,
                 const std::string& word, const std::vector<fs::path>& inputs,
                 const std::vector<fs::path>& outputs) {
  Task task = TextTask(name, inputs, outputs);
  task.stage = stage;
  task.options = "word=";
  task.options.append(word).append("\n");
  task.cost.cpu_seconds = 1;
  task.run = [=, run = task.run](const TaskRun& task_run) {
    fs::create_directories(root / "starts");
    std::ofstream(root / "starts" / name, std::ios::app) << "start\n";
    Obey(TakeHook(root, name), root, task_run.context);
    run(task_run);
    for (const fs::path& output : task_run.outputs) std::ofstream(output, std::ios::app) << word;
    return TaskCounts{{"files", static_cast<double>(task_run.outputs.size())}};
  };
  return task;
}

}  // namespace

std::vector<Task> MakeJobTasks(const fs::path& root, const std::string& word) {
  std::vector<Task> tasks;
  std::vector<fs::path> last = {root / "photo"};
  for (const std::string pass : {"first", "second"}) {
    std::vector<fs::path> outputs;
    for (int i = 0; i < 6; ++i) {
      const std::string name = pass + std::to_string(i);
      const std::string base = (root / "maps" / name).string();
      tasks.push_back(MakeJobTask(root, "passes", name, word, last, {base + ".d", base + ".n"}));
      tasks.back().temporary = pass == "first";
      tasks.back().wanted = pass != "first";
      outputs.insert(outputs.end(), tasks.back().outputs.begin(), tasks.back().outputs.end());
    }
    last = outputs;
  }
  tasks.push_back(MakeJobTask(root, "all", "all", word, last, {root / "all", root / "all.vis"}));
  return tasks;
}

void AddHook(const fs::path& root, const std::string& task, const std::string& hook) {
  fs::create_directories(root / "hooks");
  std::ofstream(root / "hooks" / task, std::ios::app) << hook << "\n";
}

size_t NumStarts(const fs::path& root, const std::string& task) {
  return ReadLines(root / "starts" / task).size();
}

}  // namespace lsmvs
