#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <map>
#include <sstream>

#include "lsmvs/execution/jobs/job_system.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/child_process.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/host_name.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

// When the process started, in the kernel's ticks: with its number it is unique until a reboot.
// Empty if it does not run.
std::string StartTime(pid_t id) {
  std::ifstream file(fmt::format("/proc/{}/stat", id));
  std::string text;
  std::getline(file, text);
  const size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) return "";
  std::istringstream fields(text.substr(name_end + 1));
  std::string field;
  constexpr int kStateField = 0, kStartField = 19;  // counted from the one after the name
  std::string start;
  for (int i = kStateField; i <= kStartField && fields >> field; ++i) {
    if (i == kStateField && field == "Z") return "";
    if (i == kStartField) start = field;
  }
  return start;
}

void Replace(const std::string& from, const std::string& to, std::string* text) {
  for (size_t at = text->find(from); at != std::string::npos; at = text->find(from, at)) {
    text->replace(at, from.size(), to);
    at += to.size();
  }
}

// The process that a command runs in, as the handle names it.
struct Submitted {
  std::string host, start;
  pid_t id = -1;

  explicit Submitted(const std::string& handle) {
    std::istringstream(handle) >> host >> id >> start;
  }
  bool Runs() const { return host == HostName() && id > 0 && StartTime(id) == start; }
};

class CommandJobs : public JobSystem {
 public:
  explicit CommandJobs(const EngineOptions& options) : options_(options) {}

  std::string name() const override { return "the command"; }

  std::string Submit(const JobBatch& batch) override {
    WriteFileAtomically(batch.folder / "commands", Commands(batch));
    WriteScript(batch);
    const fs::path log = batch.folder / "submit.log";
    const int output = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    if (output < 0) throw FileSystemError(log.string(), "create the log", errno);
    ChildProcess child("/bin/sh", {"-c", Line(batch)}, output, WhenWeEnd::kGoesOn);
    ::close(output);
    children_.emplace(child.id(), child);
    return fmt::format("{} {} {}", HostName(), child.id(), StartTime(child.id()));
  }

  // The command that runs jobs knows of one batch only.
  bool HasQueue() const override { return false; }

  // It may run, but nothing tells.
  std::optional<std::string> Find(const JobBatch& /*batch*/) override { return std::nullopt; }

  std::optional<std::vector<JobStatus>> Poll(const JobBatch& batch,
                                             const std::string& handle) override {
    const Submitted submitted(handle);
    JobStatus status;
    std::optional<int> ended;
    const auto child = children_.find(submitted.id);
    if (child != children_.end()) ended = child->second.Poll();
    if (ended) {
      status.state = HasSucceeded(*ended) ? JobState::kSucceeded : JobState::kFailed;
      if (!HasSucceeded(*ended)) status.reason = Complaint(batch, *ended);
    } else if (submitted.Runs()) {
      status.state = JobState::kRunning;
    } else if (submitted.host == HostName()) {
      status = {JobState::kFailed, "", "the submit command has ended"};
    }
    return std::vector<JobStatus>(batch.num_jobs, status);
  }

  void Cancel(const std::string& handle) override {
    const Submitted submitted(handle);
    const auto child = children_.find(submitted.id);
    if (child != children_.end()) {
      child->second.Stop();
    } else if (submitted.Runs()) {
      ::kill(-submitted.id, SIGTERM);
    }
  }

 private:
  static std::string Commands(const JobBatch& batch) {
    std::string text;
    for (size_t i = 0; i < batch.num_jobs; ++i) {
      const std::string log = ShellLine({(batch.folder / fmt::format("{}.log", i)).string()});
      text += fmt::format("{} >>{} 2>&1\n", ShellLine(CommandOf(batch, i)), log);
    }
    return text;
  }

  static fs::path ScriptPath(const JobBatch& batch) { return batch.folder / "job.sh"; }

  static void WriteScript(const JobBatch& batch) {
    WriteFileAtomically(
        ScriptPath(batch),
        fmt::format("#!/bin/sh\n"
                    "number=${{1:-${{PBS_ARRAY_INDEX:-${{PBS_ARRAYID:-${{SGE_TASK_ID:-"
                    "$SLURM_ARRAY_TASK_ID}}}}}}}}\n"
                    "eval \"$(sed -n \"${{number}}p\" {})\"\n",
                    ShellLine({(batch.folder / "commands").string()})));
    std::error_code ignored;
    fs::permissions(ScriptPath(batch), fs::perms::owner_exec, fs::perm_options::add, ignored);
  }

  std::string Line(const JobBatch& batch) const {
    std::string line = options_.submit_command;
    Replace("{commands}", ShellLine({(batch.folder / "commands").string()}), &line);
    Replace("{script}", ShellLine({ScriptPath(batch).string()}), &line);
    Replace("{folder}", ShellLine({batch.folder.string()}), &line);
    Replace("{count}", fmt::format("{}", batch.num_jobs), &line);
    Replace("{threads}", fmt::format("{}", batch.num_threads), &line);
    Replace("{memory_mb}", fmt::format("{}", (batch.memory_bytes + 999'999) / 1'000'000), &line);
    Replace("{seconds}", fmt::format("{:.0f}", batch.seconds), &line);
    return line;
  }

  static std::string Complaint(const JobBatch& batch, int status) {
    std::ifstream log(batch.folder / "submit.log");
    const std::string lines = LastLines(log);
    return fmt::format("the submit command {}{}{}", DescribeStatus(status),
                       lines.empty() ? "" : ": ", lines);
  }

  const EngineOptions options_;
  std::map<pid_t, ChildProcess> children_;
};

}  // namespace

std::unique_ptr<JobSystem> MakeCommandJobs(const EngineOptions& options) {
  return std::make_unique<CommandJobs>(options);
}

}  // namespace lsmvs
