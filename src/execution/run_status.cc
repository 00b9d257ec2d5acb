#include "lsmvs/execution/run_status.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

namespace lsmvs {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

fs::path StatusPath(const fs::path& root) { return root / "lsmvs" / "status.json"; }

}  // namespace

void WriteRunStatus(const fs::path& root, const RunStatus& status) {
  const Json json = {{"engine", status.engine},
                     {"stage", status.stage},
                     {"host", status.host},
                     {"process_id", status.process_id},
                     {"began", status.began},
                     {"updated", status.updated},
                     {"fraction_before", status.fraction_before},
                     {"fraction", status.fraction},
                     {"num_tasks", status.num_tasks},
                     {"num_done", status.num_done},
                     {"jobs_waiting", status.jobs.waiting},
                     {"jobs_running", status.jobs.running},
                     {"reason", status.jobs.reason},
                     {"nodes", status.jobs.nodes}};
  // Not worth a flush to the disk, as AtomicFile does.
  const fs::path path = StatusPath(root);
  const fs::path temporary = path.string() + ".new";
  std::error_code ignored;
  const bool is_written = static_cast<bool>(
      std::ofstream(temporary) << json.dump(1, ' ', false, Json::error_handler_t::replace) << "\n"
                               << std::flush);
  if (is_written) {
    fs::rename(temporary, path, ignored);
  } else {
    fs::remove(temporary, ignored);
  }
}

void RemoveRunStatus(const fs::path& root) {
  std::error_code ignored;
  fs::remove(StatusPath(root), ignored);
}

std::optional<RunStatus> ReadRunStatus(const fs::path& root) {
  std::ifstream file(StatusPath(root));
  if (!file) return std::nullopt;
  try {
    const Json json = Json::parse(file);
    RunStatus status;
    status.engine = json.at("engine").get<std::string>();
    status.stage = json.at("stage").get<std::string>();
    status.host = json.at("host").get<std::string>();
    status.process_id = json.at("process_id").get<int64_t>();
    status.began = json.at("began").get<int64_t>();
    status.updated = json.at("updated").get<int64_t>();
    status.fraction_before = json.at("fraction_before").get<double>();
    status.fraction = json.at("fraction").get<double>();
    status.num_tasks = json.at("num_tasks").get<size_t>();
    status.num_done = json.at("num_done").get<size_t>();
    status.jobs.waiting = json.at("jobs_waiting").get<size_t>();
    status.jobs.running = json.at("jobs_running").get<size_t>();
    status.jobs.reason = json.at("reason").get<std::string>();
    status.jobs.nodes = json.at("nodes").get<std::string>();
    return status;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace lsmvs
