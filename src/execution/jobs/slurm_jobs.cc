#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>

#include "lsmvs/execution/jobs/job_system.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/child_process.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

std::vector<std::string> Words(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::vector<std::string> Fields(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, '|');) fields.push_back(field);
  return fields;
}

fs::path Program(const std::string& name) {
  const fs::path path = FindExecutable(name);
  if (path.empty()) {
    throw Error(ExitCode::kExternalTool,
                name +
                    " was not found in PATH; start the run on a machine from which jobs can be "
                    "submitted to Slurm, or choose another --engine");
  }
  return path;
}

// "3-10:00:00" of so many seconds.
std::string TimeText(double seconds) {
  const auto minutes = static_cast<int64_t>(std::ceil(std::max(60.0, seconds) / 60));
  return fmt::format("{}-{:02}:{:02}:00", minutes / 1440, minutes / 60 % 24, minutes % 60);
}

JobState StateOf(const std::string& text) {
  static const std::map<std::string, JobState> states = {
      {"PENDING", JobState::kWaiting},     {"CONFIGURING", JobState::kWaiting},
      {"REQUEUED", JobState::kWaiting},    {"SUSPENDED", JobState::kRunning},
      {"RUNNING", JobState::kRunning},     {"COMPLETING", JobState::kRunning},
      {"COMPLETED", JobState::kSucceeded}, {"OUT_OF_MEMORY", JobState::kOutOfMemory},
      {"TIMEOUT", JobState::kOutOfTime},   {"DEADLINE", JobState::kOutOfTime},
      {"NODE_FAIL", JobState::kNodeLost},  {"BOOT_FAIL", JobState::kNodeLost},
      {"PREEMPTED", JobState::kNodeLost},  {"CANCELLED", JobState::kCancelled},
      {"FAILED", JobState::kFailed}};
  // sacct: "CANCELLED by 1000".
  const auto found = states.find(text.substr(0, text.find(' ')));
  return found == states.end() ? JobState::kRunning : found->second;
}

class SlurmJobs : public JobSystem {
 public:
  explicit SlurmJobs(const EngineOptions& options)
      : options_(options), sbatch_(Program("sbatch")), squeue_(Program("squeue")) {}

  std::string name() const override { return "Slurm"; }

  std::string Submit(const JobBatch& batch) override {
    const fs::path script = batch.folder / "job.sh";
    WriteFileAtomically(script, Script(batch));
    const ProgramOutput output = RunAndRead(sbatch_, Arguments(batch, script));
    const std::optional<std::string> id = FindId(output.text);
    if (!HasSucceeded(output.status) || !id) {
      std::istringstream text(output.text);
      throw Error(ExitCode::kExternalTool,
                  fmt::format("sbatch {}: {}; correct the --Slurm options, or --num_threads and "
                              "--max_memory, which jobs ask for at most (submitted: {})",
                              DescribeStatus(output.status), LastLines(text),
                              ShellLine(Arguments(batch, script))));
    }
    return *id;
  }

  std::optional<std::string> Find(const JobBatch& batch) override {
    const ProgramOutput output =
        RunAndRead(squeue_, {"-h", "-r", "-t", "all", "-n", batch.name, "-o", "%F"});
    const std::vector<std::string> ids = Words(output.text);
    if (!HasSucceeded(output.status) || ids.empty()) return std::nullopt;
    return ids.front();
  }

  std::optional<std::vector<JobStatus>> Poll(const JobBatch& batch,
                                             const std::string& handle) override {
    std::vector<JobStatus> jobs(batch.num_jobs);
    const ProgramOutput queue =
        RunAndRead(squeue_, {"-h", "-r", "-t", "all", "-n", batch.name, "-o", "%F|%K|%T|%N|%r"});
    // A name that the queue has forgotten gives an empty answer; an error means no answer.
    if (!HasSucceeded(queue.status)) return std::nullopt;
    ReadQueue(queue.text, handle, &jobs);
    const bool all_known = std::all_of(jobs.begin(), jobs.end(), [](const JobStatus& job) {
      return job.state != JobState::kUnknown;
    });
    if (!all_known) ReadAccounting(handle, &jobs);
    return jobs;
  }

  bool HasQueue() const override { return true; }

  void Cancel(const std::string& handle) override { RunAndRead(Program("scancel"), {handle}); }

  std::optional<JobLimits> Limits() const override {
    std::vector<std::string> arguments = {"-h", "-e", "-o", "%c|%m|%D"};
    if (!options_.partition.empty()) arguments.insert(arguments.end(), {"-p", options_.partition});
    const ProgramOutput output = RunAndRead(Program("sinfo"), arguments);
    if (!HasSucceeded(output.status)) {
      std::istringstream text(output.text);
      throw Error(ExitCode::kExternalTool,
                  fmt::format("sinfo {}: {}; check that Slurm runs (sinfo, scontrol ping)",
                              DescribeStatus(output.status), LastLines(text)));
    }
    JobLimits limits{0, 0, 0};
    std::istringstream lines(output.text);
    for (std::string line; std::getline(lines, line);) {
      const std::vector<std::string> fields = Fields(line);
      if (fields.size() != 3) continue;
      // Nodes of several kinds: "64+".
      const int num_threads = std::atoi(fields[0].c_str());
      limits.num_threads = std::max(limits.num_threads, num_threads);
      limits.num_threads_in_all += num_threads * std::atoi(fields[2].c_str());
      limits.memory_bytes =
          std::max(limits.memory_bytes, static_cast<size_t>(std::atoll(fields[1].c_str())) << 20);
    }
    if (limits.num_threads > 0) return limits;
    throw Error(ExitCode::kExternalTool,
                options_.partition.empty()
                    ? std::string("Slurm has no nodes; see sinfo")
                    : fmt::format("Slurm has no partition '{}' with nodes; sinfo lists them, "
                                  "correct --Slurm.partition",
                                  options_.partition));
  }

 private:
  static std::string Script(const JobBatch& batch) {
    std::vector<std::string> first(batch.command.begin(), batch.command.end() - 1);
    return fmt::format("#!/bin/sh\nexec {} {}\"$SLURM_ARRAY_TASK_ID\"\n", ShellLine(first),
                       ShellLine({batch.command.back()}));
  }

  std::vector<std::string> Arguments(const JobBatch& batch, const fs::path& script) const {
    // What is requeued by Slurm itself would run twice on the same folder.
    std::vector<std::string> arguments = {
        "--parsable",
        "--no-requeue",
        "--nodes=1",
        "--ntasks=1",
        "--open-mode=append",
        "--job-name=" + batch.name,
        fmt::format("--array=0-{}%{}", batch.num_jobs - 1, options_.max_jobs),
        fmt::format("--cpus-per-task={}", batch.num_threads),
        fmt::format("--mem={}M", (batch.memory_bytes + (1 << 20) - 1) >> 20),
        "--time=" + (options_.time.empty() ? TimeText(batch.seconds) : options_.time),
        "--output=" + (batch.folder / "%a.log").string(),
        "--error=" + (batch.folder / "%a.log").string()};
    if (!options_.partition.empty()) arguments.push_back("--partition=" + options_.partition);
    if (!options_.account.empty()) arguments.push_back("--account=" + options_.account);
    for (const std::string& word : Words(options_.extra)) arguments.push_back(word);
    arguments.push_back(script.string());
    return arguments;
  }

  // Of --parsable: "123" or "123;cluster", perhaps after warnings.
  static std::optional<std::string> FindId(const std::string& text) {
    std::istringstream lines(text);
    std::optional<std::string> id;
    for (std::string line; std::getline(lines, line);) {
      const std::string first = line.substr(0, line.find(';'));
      const bool is_number = !first.empty() && std::all_of(first.begin(), first.end(), [](char c) {
        return std::isdigit(static_cast<unsigned char>(c)) != 0;
      });
      if (is_number) id = first;
    }
    return id;
  }

  static void Set(const std::string& number_text, const JobStatus& status,
                  std::vector<JobStatus>* jobs) {
    size_t number = 0;
    const char* end = number_text.data() + number_text.size();
    const auto [rest, error] = std::from_chars(number_text.data(), end, number);
    if (error != std::errc() || rest != end || number >= jobs->size()) return;
    (*jobs)[number] = status;
  }

  static void ReadQueue(const std::string& text, const std::string& handle,
                        std::vector<JobStatus>* jobs) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      const std::vector<std::string> fields = Fields(line);
      if (fields.size() < 5 || fields[0] != handle) continue;
      Set(fields[1], {StateOf(fields[2]), fields[3], fields[4]}, jobs);
    }
  }

  // Where accounting is off, nothing becomes known.
  static void ReadAccounting(const std::string& handle, std::vector<JobStatus>* jobs) {
    const fs::path sacct = FindExecutable("sacct");
    if (sacct.empty()) return;
    const ProgramOutput output =
        RunAndRead(sacct, {"-n", "-P", "-X", "-j", handle, "-o", "JobID,State,NodeList"});
    if (!HasSucceeded(output.status)) return;
    std::istringstream lines(output.text);
    for (std::string line; std::getline(lines, line);) {
      const std::vector<std::string> fields = Fields(line);
      const size_t split = fields.empty() ? std::string::npos : fields[0].find('_');
      if (fields.size() < 2 || split == std::string::npos) continue;
      const size_t number_begin = split + 1;
      Set(fields[0].substr(number_begin),
          {StateOf(fields[1]), fields.size() > 2 ? fields[2] : std::string(), fields[1]}, jobs);
    }
  }

  const EngineOptions options_;
  const fs::path sbatch_, squeue_;
};

}  // namespace

std::unique_ptr<JobSystem> MakeSlurmJobs(const EngineOptions& options) {
  return std::make_unique<SlurmJobs>(options);
}

}  // namespace lsmvs
