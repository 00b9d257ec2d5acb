#include "lsmvs/execution/jobs/job_files.h"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/hash.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

fs::path ProgressPath(const fs::path& slice_folder) { return slice_folder / "progress"; }

}  // namespace

fs::path SliceFolder(const fs::path& batch_folder, size_t slice) {
  return batch_folder / fmt::format("{}", slice);
}

fs::path LogPath(const fs::path& batch_folder, size_t slice) {
  return batch_folder / fmt::format("{}.log", slice);
}

fs::path OutcomePath(const fs::path& slice_folder, size_t position) {
  return slice_folder / fmt::format("{}.json", position);
}

fs::path LeaderPath(const fs::path& slice_folder) { return slice_folder / "leader"; }

// Outputs outside the run's folder lie beside their places, so that they can be renamed.
fs::path JobOutputPath(const fs::path& slice_folder, const std::string& key, JobOutput state) {
  const fs::path path = key;
  const std::string folder = state == JobOutput::kDone ? "files" : "writing";
  if (path.is_relative()) return slice_folder / folder / path;
  const std::string name = Hasher().Update(slice_folder.string()).HexDigest().substr(0, 16);
  return path.parent_path() / (".lsmvs-job-" + name + "-" + folder) / path.filename();
}

void WriteOutcome(const fs::path& path, const TaskOutcome& outcome) {
  Json json = {{"node", outcome.node}};
  if (outcome.done) {
    json["done"] = ToText(*outcome.done);
  } else {
    json["code"] = static_cast<int>(outcome.code);
    json["error"] = outcome.error;
  }
  WriteFileAtomically(path, json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::optional<TaskOutcome> ReadOutcome(const fs::path& path) {
  std::ifstream file(path);
  if (!file) return std::nullopt;
  try {
    const Json json = Json::parse(file);
    TaskOutcome outcome;
    outcome.node = json.at("node").get<std::string>();
    if (json.contains("done")) {
      outcome.done = PublishingFromText(json["done"].get<std::string>());
    } else {
      outcome.code = static_cast<ExitCode>(json.at("code").get<int>());
      outcome.error = json.at("error").get<std::string>();
    }
    return outcome;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

// Not worth a flush to the disk; a line that is cut off reads as no progress.
void WriteProgress(const fs::path& slice_folder, const JobProgress& progress) {
  std::ofstream(ProgressPath(slice_folder))
      << fmt::format("{} {:.4f}\n", progress.position, progress.fraction);
}

JobProgress ReadProgress(const fs::path& slice_folder) {
  JobProgress progress;
  std::ifstream file(ProgressPath(slice_folder));
  if (!(file >> progress.position >> progress.fraction)) return {};
  return progress;
}

}  // namespace lsmvs
