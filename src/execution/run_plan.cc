#include "lsmvs/execution/run_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "lsmvs/util/error.h"
#include "lsmvs/util/hash.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

std::vector<std::string> OutputKeys(const Task& task, const FileTable& files) {
  std::vector<std::string> keys;
  for (const fs::path& output : task.outputs) keys.push_back(files.Key(output));
  return keys;
}

// Whether a record is of these outputs; those that its run added come after them.
bool WroteOutputs(const TaskRecord& record, const Task& task, const FileTable& files) {
  const std::vector<std::string> keys = OutputKeys(task, files);
  return record.outputs.size() >= keys.size() &&
         std::equal(keys.begin(), keys.end(), record.outputs.begin());
}

[[noreturn]] void ThrowConflict(const std::string& path) {
  throw Error(ExitCode::kOverwrite,
              path +
                  ": is there already and was not made by this program in this workspace (or was "
                  "changed since); move it away, or give --overwrite to replace it");
}

// What is known of a task before it is decided whether it is needed.
struct Finding {
  bool foreign_used = false;
  std::string conflict;  // a foreign file that is in the way
  bool outputs_missing = false;
  std::string reason;  // empty: up to date, but for outputs that are missing
};

class Planner {
 public:
  Planner(const std::vector<Task>& tasks, const PlanOptions& options, RunStore* store)
      : tasks_(tasks), options_(options), store_(*store), findings_(tasks.size()) {
    for (size_t i = 0; i < tasks.size(); ++i) {
      for (const fs::path& output : tasks[i].outputs) producer_[Key(output)] = i;
    }
  }

  RunPlan Plan() {
    for (size_t i = 0; i < tasks_.size(); ++i) findings_[i] = Examine(tasks_[i]);
    RunPlan plan;
    plan.tasks.resize(tasks_.size());
    needed_.assign(tasks_.size(), false);
    for (size_t i = tasks_.size(); i-- > 0;) {
      plan.tasks[i] = Decide(i);
      if (plan.tasks[i].state == TaskState::kRun) {
        plan.tasks[i].resident_bytes = ResidentBytesOf(tasks_[i]);
      }
    }
    return plan;
  }

 private:
  // Of a task that works with a scratch file, else 0.
  size_t ResidentBytesOf(const Task& task) const {
    const size_t needed = task.cost.peak_bytes;
    if (task.least_bytes == 0) return 0;
    if (options_.num_parts <= 1 && needed <= options_.memory_bytes) return 0;
    const size_t part = needed / static_cast<size_t>(std::max(1, options_.num_parts));
    return std::max(task.least_bytes, std::min(part, options_.memory_bytes));
  }

  std::string Key(const fs::path& path) { return store_.files().Key(path); }

  Finding Examine(const Task& task) {
    Finding finding;
    size_t num_foreign = 0, num_missing = 0;
    for (const fs::path& output : task.outputs) {
      if (fs::is_directory(output)) ThrowFolder(output);
      if (!fs::exists(output)) {
        ++num_missing;
      } else if (store_.files().MadeBy(output).empty()) {
        ++num_foreign;
        finding.conflict = output.string();
      }
    }
    if (options_.overwrite && num_foreign > 0) {
      finding.conflict.clear();
      finding.reason = "--overwrite replaces what is there";
      return finding;
    }
    finding.outputs_missing = num_missing > 0 || LacksAddedOutputs(task);
    finding.foreign_used =
        num_foreign > 0 && num_missing == 0 && task.foreign_outputs == ForeignOutputs::kUse;
    if (finding.foreign_used) {
      finding.conflict.clear();
    } else {
      finding.reason = Staleness(task);
    }
    return finding;
  }

  // Outputs that the last run added, if not all are as it made them.
  bool LacksAddedOutputs(const Task& task) {
    const auto found = store_.tasks().find(task.name);
    if (found == store_.tasks().end()) return false;
    const std::vector<std::string>& keys = found->second.outputs;
    for (size_t i = task.outputs.size(); i < keys.size(); ++i) {
      if (store_.files().MadeBy(store_.files().PathOfKey(keys[i])) != task.name) return true;
    }
    return false;
  }

  // Compares with the record. Inputs that are not there yet are known by their makers.
  std::string Staleness(const Task& task) {
    const auto found = store_.tasks().find(task.name);
    if (found == store_.tasks().end()) return "new";
    const TaskRecord& record = found->second;
    if (record.version != task.version) return "the method is a newer version";
    if (record.options != task.options) return "options changed";
    if (!WroteOutputs(record, task, store_.files())) return "it writes to other files";
    const std::optional<std::string> inputs = ForeseenInputsHash(task);
    if (!inputs) return "its input is made anew";
    if (record.inputs_hash != *inputs) return "input changed";
    return MadeAllOutputs(task) ? "" : "its result was replaced";
  }

  // Another task may have written the same files since: its bytes are then the ones on record.
  bool MadeAllOutputs(const Task& task) {
    return std::all_of(task.outputs.begin(), task.outputs.end(), [&](const fs::path& output) {
      return store_.files().RecordedMaker(output) == task.name;
    });
  }

  std::optional<std::string> ForeseenInputsHash(const Task& task) {
    Hasher hasher;
    for (const fs::path& input : task.inputs) {
      const std::optional<std::string> hash = ForeseenHash(input);
      if (!hash) return std::nullopt;
      hasher.Update(Key(input)).Update(*hash);
    }
    return hasher.HexDigest();
  }

  // Hash that a file has or will have; nothing if that cannot be known yet.
  std::optional<std::string> ForeseenHash(const fs::path& input) {
    const auto made = producer_.find(Key(input));
    if (made != producer_.end()) {
      const Finding& finding = findings_[made->second];
      if (!finding.foreign_used && !finding.reason.empty()) return std::nullopt;
      if (!fs::exists(input)) return store_.files().RecordedHash(input);
    }
    return store_.files().Hash(input);
  }

  PlannedTask Decide(size_t i) {
    const Task& task = tasks_[i];
    const Finding& finding = findings_[i];
    if (!task.wanted && !needed_[i]) return {TaskState::kNotNeeded, ""};
    if (!finding.conflict.empty()) ThrowConflict(finding.conflict);
    if (finding.foreign_used) return {TaskState::kForeign, ""};
    if (finding.reason.empty() && !finding.outputs_missing) return {TaskState::kUpToDate, ""};
    for (const fs::path& input : task.inputs) {
      const auto made = producer_.find(Key(input));
      if (made != producer_.end()) {
        needed_[made->second] = true;
      } else if (!fs::exists(input)) {
        throw InputError(input.string(), "is missing, and " + task.stage + " reads it",
                         "run first what makes it, or correct its path");
      } else {
        StampOf(input);  // throws if it cannot be read
      }
    }
    return {TaskState::kRun, finding.reason.empty() ? "its result is missing" : finding.reason};
  }

  [[noreturn]] static void ThrowFolder(const fs::path& path) {
    throw InputError(path.string(), "is a folder, but a file is to be written there",
                     "name a file, such as " + (path / "result.ply").string());
  }

  const std::vector<Task>& tasks_;
  const PlanOptions& options_;
  RunStore& store_;
  std::map<std::string, size_t> producer_;
  std::vector<Finding> findings_;
  std::vector<bool> needed_;
};

void Count(const PlannedTask& planned, const Task& task, PlannedStage* stage) {
  if (planned.state == TaskState::kUpToDate) ++stage->num_up_to_date;
  if (planned.state == TaskState::kForeign) ++stage->num_foreign;
  if (planned.state != TaskState::kRun) return;
  if (stage->num_run++ == 0) stage->reason = planned.reason;
  stage->output_bytes += task.output_bytes;
  // Measured on towns of 3 to 27 million vertices in a quarter to an eighth of their memory.
  constexpr double kTimeWithScratch = 1.3;
  const bool on_disk = planned.resident_bytes > 0;
  stage->cost.cpu_seconds += task.cost.cpu_seconds * (on_disk ? kTimeWithScratch : 1);
  stage->cost.peak_bytes =
      std::max(stage->cost.peak_bytes, on_disk ? planned.resident_bytes : task.cost.peak_bytes);
  if (on_disk) {
    stage->scratch_bytes =
        std::max<uint64_t>(stage->scratch_bytes, task.cost.peak_bytes + task.checkpoint_bytes);
  }
}

std::vector<PlannedStage> SumUp(const std::vector<Task>& tasks,
                                const std::vector<PlannedTask>& planned) {
  std::vector<PlannedStage> stages;
  for (size_t i = 0; i < tasks.size(); ++i) {
    if (stages.empty() || stages.back().name != tasks[i].stage) {
      stages.push_back({});
      stages.back().name = tasks[i].stage;
      stages.back().begin = i;
    }
    stages.back().end = i + 1;
    Count(planned[i], tasks[i], &stages.back());
  }
  return stages;
}

// Which tasks read what a temporary one makes.
std::vector<std::vector<size_t>> FindReaders(const std::vector<Task>& tasks, FileTable* files) {
  std::map<std::string, size_t> producer;
  for (size_t i = 0; i < tasks.size(); ++i) {
    if (!tasks[i].temporary) continue;
    for (const fs::path& output : tasks[i].outputs) producer[files->Key(output)] = i;
  }
  std::vector<std::vector<size_t>> readers(tasks.size());
  if (producer.empty()) return readers;
  for (size_t i = 0; i < tasks.size(); ++i) {
    for (const fs::path& input : tasks[i].inputs) {
      const auto made = producer.find(files->Key(input));
      if (made == producer.end()) continue;
      std::vector<size_t>& list = readers[made->second];
      if (list.empty() || list.back() != i) list.push_back(i);
    }
  }
  return readers;
}

// Sets drops and leftovers.
void PlanDrops(const std::vector<Task>& tasks, FileTable* files, RunPlan* plan) {
  plan->drops.assign(tasks.size(), {});
  const std::vector<std::vector<size_t>> readers = FindReaders(tasks, files);
  for (size_t i = 0; i < tasks.size(); ++i) {
    const auto state = [&](size_t reader) { return plan->tasks[reader].state; };
    const bool all_needed = std::all_of(readers[i].begin(), readers[i].end(), [&](size_t reader) {
      return state(reader) != TaskState::kNotNeeded;
    });
    if (readers[i].empty() || !all_needed) continue;
    const auto last = std::find_if(readers[i].rbegin(), readers[i].rend(),
                                   [&](size_t reader) { return state(reader) == TaskState::kRun; });
    if (last != readers[i].rend()) {
      plan->drops[*last].push_back(i);
    } else {
      plan->leftovers.push_back(i);
    }
  }
}

uint64_t BytesOnDisk(const Task& task) {
  uint64_t bytes = 0;
  for (const fs::path& output : task.outputs) {
    std::error_code error;
    const auto size = fs::file_size(output, error);
    if (!error) bytes += size;
  }
  return bytes;
}

// New files stand beside those that they replace until they are complete.
uint64_t PeakDiskBytes(const std::vector<Task>& tasks, const RunPlan& plan) {
  int64_t now = 0, peak = 0;
  for (size_t i = 0; i < tasks.size(); ++i) {
    if (plan.tasks[i].state != TaskState::kRun) continue;
    now += static_cast<int64_t>(tasks[i].output_bytes);
    peak = std::max(peak, now);
    now -= static_cast<int64_t>(BytesOnDisk(tasks[i]));
    for (const size_t dropped : plan.drops[i]) {
      now -= static_cast<int64_t>(plan.tasks[dropped].state == TaskState::kRun
                                      ? tasks[dropped].output_bytes
                                      : BytesOnDisk(tasks[dropped]));
    }
  }
  return static_cast<uint64_t>(peak);
}

}  // namespace

CostEstimate RunPlan::Cost() const {
  CostEstimate total;
  for (const PlannedStage& stage : stages) {
    total.cpu_seconds += stage.cost.cpu_seconds;
    total.peak_bytes = std::max(total.peak_bytes, stage.cost.peak_bytes);
  }
  return total;
}

size_t RunPlan::NumToRun() const {
  size_t count = 0;
  for (const PlannedStage& stage : stages) count += stage.num_run;
  return count;
}

RunPlan PlanRun(const std::vector<Task>& tasks, const PlanOptions& options, RunStore* store) {
  RunPlan plan = Planner(tasks, options, store).Plan();
  plan.overwrite = options.overwrite;
  plan.stages = SumUp(tasks, plan.tasks);
  PlanDrops(tasks, &store->files(), &plan);
  plan.scratch_folder = options.scratch_folder;
  plan.process_bytes = options.process_bytes;
  plan.peak_disk_bytes = PeakDiskBytes(tasks, plan);
  for (const PlannedStage& stage : plan.stages) {
    plan.peak_scratch_bytes = std::max(plan.peak_scratch_bytes, stage.scratch_bytes);
  }
  return plan;
}

bool MeasureCosts(const RunPlan& plan, std::vector<Task>* tasks) {
  std::set<fs::path> to_be_made;
  bool any = false;
  for (size_t i = 0; i < tasks->size(); ++i) {
    Task& task = (*tasks)[i];
    if (plan.tasks[i].state != TaskState::kRun) continue;
    to_be_made.insert(task.outputs.begin(), task.outputs.end());
    const bool ready = std::all_of(task.inputs.begin(), task.inputs.end(), [&](const auto& input) {
      return fs::exists(input) && !to_be_made.contains(input);
    });
    if (!ready || !task.measure_cost) continue;
    task.measure_cost(&task);
    any = true;
  }
  return any;
}

std::string HashInputs(const Task& task, FileTable* files) {
  Hasher hasher;
  for (const fs::path& input : task.inputs) {
    hasher.Update(files->Key(input)).Update(files->Hash(input));
  }
  return hasher.HexDigest();
}

void CheckReplaceable(const fs::path& output, FileTable* files) {
  if (fs::exists(output) && files->MadeBy(output).empty()) ThrowConflict(output.string());
}

std::string ReasonToRun(const Task& task, RunStore* store) {
  const auto found = store->tasks().find(task.name);
  if (found == store->tasks().end()) return "new";
  const TaskRecord& record = found->second;
  if (record.version != task.version || record.options != task.options) return "options changed";
  if (!WroteOutputs(record, task, store->files())) return "it writes to other files";
  if (record.inputs_hash != HashInputs(task, &store->files())) return "input changed";
  for (const std::string& key : record.outputs) {
    const fs::path output = store->files().PathOfKey(key);
    if (store->files().MadeBy(output) != task.name) return "its result is missing";
  }
  return "";
}

}  // namespace lsmvs
