#include "job_tasks.h"

#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <sstream>
#include <thread>
#include <utility>

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

constexpr size_t kNumItems = 60;

std::string ItemText(const std::string& word, size_t item) {
  return " " + word + std::to_string(item);
}

// A helper of the last task. It obeys hooks, too.
class TextWorker : public LoopWorker {
 public:
  explicit TextWorker(fs::path root) : root_(std::move(root)) {}
  void SetState(int /*key*/, std::string bytes) override { word_ = std::move(bytes); }
  void Begin(int /*kind*/) override {
    std::ofstream(root_ / "starts/helper", std::ios::app) << "start\n";
    Obey(TakeHook(root_, "helper"), root_, RunContext(1));
  }
  std::string Compute(int /*kind*/, size_t item) override {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return ItemText(word_, item);
  }

 private:
  const fs::path root_;
  std::string word_;
};

// Appends what the items give, in their order.
void AppendItems(const std::string& word, const fs::path& output, const RunContext& context) {
  std::vector<std::string> texts(kNumItems);
  SharedLoop loop;
  loop.count = kNumItems;
  loop.states = [&] {
    return std::vector<LoopState>{{1, std::make_shared<const std::string>(word)}};
  };
  loop.compute = [&](size_t item, const std::function<bool()>& is_first) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (is_first()) texts[item] = ItemText(word, item);
  };
  loop.keep = [&](size_t item, std::string_view text) { texts[item] = text; };
  RunSharedLoop(loop, context);
  std::ofstream file(output, std::ios::app);
  for (const std::string& text : texts) file << text;
}

// Of the last task: several loops, if there are helpers until one has come.
void ShareLoops(const fs::path& root, const std::string& word, const TaskRun& run) {
  for (int i = 0; i < 10; ++i) AppendItems(word, run.outputs.front(), run.context);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  const fs::path unused = run.outputs.front().string() + ".unused";
  while (run.context.helpers != nullptr && NumStarts(root, "helper") == 0 &&
         std::chrono::steady_clock::now() < end) {
    AppendItems(word, unused, run.context);
  }
  fs::remove(unused);
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
  Task& all = tasks.back();
  all.run = [=, run = all.run](const TaskRun& task_run) {
    TaskCounts counts = run(task_run);
    ShareLoops(root, word, task_run);
    return counts;
  };
  all.max_helpers = 2;
  all.make_worker = [=](const RunContext&) { return std::make_unique<TextWorker>(root); };
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
