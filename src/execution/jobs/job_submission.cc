#include "lsmvs/execution/jobs/job_submission.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "lsmvs/util/error.h"
#include "lsmvs/util/hash.h"
#include "lsmvs/util/host_name.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

// Slurm's default MaxArraySize is 1001.
constexpr size_t kMaxBatch = 1000;
// Where batches wait in a queue: jobs that are to be there beyond those that run.
constexpr size_t kQueued = 2;

std::string UniqueName(const fs::path& root) {
  const auto now = std::chrono::system_clock::now().time_since_epoch().count();
  const std::string text =
      fmt::format("{} {} {} {}", HostName(), ::getpid(), now, fs::absolute(root).string());
  return "lsmvs-" + Hasher().Update(text).HexDigest().substr(0, 12);
}

}  // namespace

JobSubmission::JobSubmission(StageJobs* jobs, ReadyTasks* tasks)
    : jobs_(*jobs),
      tasks_(*tasks),
      lengths_(LengthsOfJobs(tasks->seconds_left(), jobs->num_threads, jobs->JobsAtOnce(),
                             jobs->options)) {}

void JobSubmission::Adopt() {
  std::map<std::string, size_t> task_of_name;
  for (const size_t i : tasks_.ready()) task_of_name[jobs_.work.tasks()[i].name] = i;
  size_t num_adopted = 0;
  for (const fs::path& folder : FindBatchFolders(jobs_.root)) {
    std::optional<LiveBatch> batch = Reopen(folder, task_of_name);
    if (batch && batch->NumOpen() > 0) {
      num_adopted += batch->NumOpen();
      jobs_.batches.push_back(*std::move(batch));
    } else {
      if (batch && !batch->handle.empty()) jobs_.system.Cancel(batch->handle);
      std::error_code ignored;
      fs::remove_all(folder, ignored);
    }
  }
  if (num_adopted > 0) {
    jobs_.Note(fmt::format("goes on with {} jobs of an earlier start of this run", num_adopted));
  }
}

std::optional<LiveBatch> JobSubmission::Reopen(const fs::path& folder,
                                               const std::map<std::string, size_t>& task_of_name) {
  if (IsAbandoned(folder)) return std::nullopt;
  LiveBatch batch;
  batch.folder = folder;
  try {
    batch.order = ReadJobOrder(folder);
  } catch (const InputError&) {
    return std::nullopt;  // killed before it was written
  }
  if (batch.order.engine != jobs_.system.name()) return std::nullopt;
  batch.slices.resize(batch.order.slices.size());
  const JobBatch description = batch.ToJobBatch(jobs_.command.program, jobs_.root);
  batch.handle = ReadHandle(folder).value_or("");
  if (batch.handle.empty()) batch.handle = jobs_.system.Find(description).value_or("");
  if (batch.handle.empty()) return std::nullopt;
  for (size_t s = 0; s < batch.slices.size(); ++s) {
    for (const OrderedTask& ordered : batch.order.slices[s]) {
      const auto found = task_of_name.find(ordered.name);
      const bool is_wanted = found != task_of_name.end() &&
                             tasks_.ready().contains(found->second) &&
                             IsSame(ordered, found->second);
      if (is_wanted) tasks_.Take(found->second);
      batch.slices[s].task_idxs.push_back(is_wanted ? found->second : 0);
      batch.slices[s].is_collected.push_back(!is_wanted);
    }
  }
  return batch;
}

bool JobSubmission::IsSame(const OrderedTask& ordered, size_t i) {
  FileTable& files = jobs_.work.store()->files();
  const Task& task = jobs_.work.tasks()[i];
  return ordered.identity == IdentityOf(task, files) &&
         ordered.inputs_hash == HashInputs(task, &files);
}

bool JobSubmission::MaySubmitAgain() const { return !jobs_.again.empty() && NumFree() > 0; }

void JobSubmission::Submit() {
  SubmitAgain();
  SubmitReady();
}

// Tasks of equal needs share batches.
void JobSubmission::SubmitAgain() {
  if (!MaySubmitAgain()) return;
  std::map<std::pair<double, double>, std::vector<size_t>> groups;
  for (const size_t i : std::exchange(jobs_.again, {})) {
    const TaskHistory& history = jobs_.history[i];
    groups[{history.memory_factor, history.time_factor}].push_back(i);
  }
  for (const auto& [factors, task_idxs] : groups) {
    TaskHistory needs;
    std::tie(needs.memory_factor, needs.time_factor) = factors;
    double cpu_seconds = 0;
    for (const size_t i : task_idxs) cpu_seconds += jobs_.work.tasks()[i].cost.cpu_seconds;
    const size_t num_free = NumFree();
    auto slices = SliceTasks(jobs_.work.tasks(), task_idxs, lengths_, cpu_seconds);
    for (size_t s = num_free; s < slices.size(); ++s) {
      jobs_.again.insert(slices[s].begin(), slices[s].end());
    }
    if (slices.size() > num_free) slices.resize(num_free);
    if (!slices.empty()) SubmitBatch(slices, needs);
  }
}

void JobSubmission::SubmitReady() {
  const size_t num_wanted = NumWanted();
  if (num_wanted == 0 || tasks_.ready().empty()) return;
  const std::vector<size_t> ready(tasks_.ready().begin(), tasks_.ready().end());
  double ready_seconds = 0;
  for (const size_t i : ready) ready_seconds += jobs_.work.tasks()[i].cost.cpu_seconds;
  // What can run now is divided evenly: the tasks that follow may need all of it.
  const SliceLengths lengths =
      LengthsOfJobs(ready_seconds, jobs_.num_threads, jobs_.JobsAtOnce(), jobs_.options);
  auto slices = SliceTasks(jobs_.work.tasks(), ready, lengths, ready_seconds, num_wanted);
  // While machines are busy, a job that would be short waits for tasks that are not ready yet.
  const bool may_wait = jobs_.NumOpen() >= jobs_.JobsAtOnce() && tasks_.NumBlocked() > 0;
  if (may_wait) std::erase_if(slices, [&](const auto& slice) { return IsShort(slice); });
  for (std::vector<size_t>& slice : slices) {
    std::erase_if(slice, [&](size_t i) {
      tasks_.Take(i);
      if (!jobs_.work.Skip(i)) return false;
      jobs_.done.insert(i);
      return true;
    });
  }
  std::erase_if(slices, [](const auto& slice) { return slice.empty(); });
  if (!slices.empty()) SubmitBatch(slices, {});
}

// Jobs that machines have use for.
size_t JobSubmission::NumWanted() const {
  const size_t num_open = jobs_.NumOpen();
  if (!jobs_.system.HasQueue()) return NumFree();
  const size_t at_once = jobs_.JobsAtOnce();
  if (num_open > at_once) return 0;
  return std::min(NumFree(), (1 + kQueued) * at_once - num_open);
}

// Jobs that may be submitted now: a command runs one batch after the other, of any size; in a queue
// no more are open than may run at once.
size_t JobSubmission::NumFree() const {
  const size_t num_open = jobs_.NumOpen();
  if (!jobs_.system.HasQueue()) {
    return num_open == 0 ? std::numeric_limits<size_t>::max() : 0;
  }
  const auto most = static_cast<size_t>(jobs_.options.max_jobs);
  return std::min(kMaxBatch, most - std::min(most, num_open));
}

bool JobSubmission::IsShort(const std::vector<size_t>& slice) const {
  double seconds = 0;
  for (const size_t i : slice) seconds += jobs_.work.tasks()[i].cost.cpu_seconds;
  return seconds < 0.5 * lengths_.Next(tasks_.seconds_left());
}

void JobSubmission::SubmitBatch(const std::vector<std::vector<size_t>>& slices,
                                const TaskHistory& history) {
  jobs_.work.context().ThrowIfCancelled();
  LiveBatch batch;
  JobOrder& order = batch.order;
  order.engine = jobs_.system.name();
  order.batch_name = UniqueName(jobs_.root);
  order.command_name = jobs_.command.name;
  order.arguments = jobs_.command.arguments;
  order.working_folder = fs::current_path();
  order.scratch_folder = fs::absolute(jobs_.work.plan().scratch_folder);
  order.overwrite = jobs_.work.plan().overwrite;
  order.num_threads = jobs_.num_threads;
  for (const auto& slice : slices) AddSlice(slice, history, &batch);
  if (slices.size() == 1 && slices.front().size() == 1) {
    const size_t i = slices.front().front();
    order.num_helpers = NumHelpers(jobs_.work.tasks()[i], jobs_.work.plan().tasks[i],
                                   order.num_threads, jobs_.JobsAtOnce(), jobs_.options);
  }
  batch.folder = MakeBatchFolder(jobs_.root, order);
  batch.handle = jobs_.system.Submit(batch.ToJobBatch(jobs_.command.program, jobs_.root));
  WriteHandle(batch.folder, batch.handle);
  jobs_.batches.push_back(std::move(batch));
  jobs_.last_event = jobs_.last_submission = StageJobs::Clock::now();
  jobs_.has_noted_waiting = false;
}

void JobSubmission::AddSlice(const std::vector<size_t>& task_idxs, const TaskHistory& history,
                             LiveBatch* batch) {
  FileTable& files = jobs_.work.store()->files();
  JobOrder& order = batch->order;
  std::vector<OrderedTask> ordered;
  double cpu_seconds = 0;
  for (const size_t i : task_idxs) {
    jobs_.work.context().ThrowIfCancelled();  // photos are read to be hashed
    const Task& task = jobs_.work.tasks()[i];
    const PlannedTask& planned = jobs_.work.plan().tasks[i];
    ordered.push_back(
        {task.name, IdentityOf(task, files), HashInputs(task, &files), planned.resident_bytes});
    cpu_seconds += task.cost.cpu_seconds;
    order.memory_bytes = std::max(
        order.memory_bytes,
        JobMemoryBytes(task, planned, jobs_.process_bytes, history.memory_factor, jobs_.limits));
  }
  order.seconds =
      std::max(order.seconds, JobTimeLimit(cpu_seconds, jobs_.num_threads, history.time_factor));
  order.slices.push_back(std::move(ordered));
  LiveSlice slice;
  slice.task_idxs = task_idxs;
  slice.is_collected.assign(task_idxs.size(), false);
  batch->slices.push_back(std::move(slice));
}

}  // namespace lsmvs
