#include "lsmvs/execution/job_order.h"

#include <charconv>
#include <fstream>
#include <nlohmann/json.hpp>

#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/hash.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kFormat = 2;
constexpr const char* kOrderFile = "order.json";

Json ToJson(const OrderedTask& task) {
  return {{"name", task.name},
          {"identity", task.identity},
          {"inputs_hash", task.inputs_hash},
          {"resident_bytes", task.resident_bytes}};
}

OrderedTask TaskFromJson(const Json& json) {
  return {json.at("name").get<std::string>(), json.at("identity").get<std::string>(),
          json.at("inputs_hash").get<std::string>(), json.at("resident_bytes").get<size_t>()};
}

JobOrder OrderFromJson(const Json& json) {
  if (json.at("format").get<int>() != kFormat) throw std::invalid_argument("unknown format");
  JobOrder order;
  order.engine = json.at("engine").get<std::string>();
  order.batch_name = json.at("batch").get<std::string>();
  order.command_name = json.at("command").get<std::string>();
  order.arguments = json.at("arguments").get<std::vector<std::string>>();
  order.working_folder = json.at("working_folder").get<std::string>();
  order.scratch_folder = json.at("scratch_folder").get<std::string>();
  order.overwrite = json.at("overwrite").get<bool>();
  order.num_threads = json.at("num_threads").get<int>();
  order.memory_bytes = json.at("memory_bytes").get<size_t>();
  order.seconds = json.at("seconds").get<double>();
  order.num_helpers = json.at("num_helpers").get<size_t>();
  for (const Json& slice : json.at("slices")) {
    order.slices.emplace_back();
    for (const Json& task : slice) order.slices.back().push_back(TaskFromJson(task));
  }
  return order;
}

}  // namespace

std::string IdentityOf(const Task& task, const FileTable& files) {
  Hasher hasher;
  hasher.Update(task.name).Update(task.version).Update(task.options);
  for (const fs::path& input : task.inputs) hasher.Update(files.Key(input));
  for (const fs::path& output : task.outputs) hasher.Update(files.Key(output));
  return hasher.HexDigest();
}

fs::path JobsFolder(const fs::path& root) { return root / "lsmvs" / "jobs"; }

void WriteJobOrder(const fs::path& batch_folder, const JobOrder& order) {
  Json json = {{"format", kFormat},
               {"engine", order.engine},
               {"batch", order.batch_name},
               {"command", order.command_name},
               {"arguments", order.arguments},
               {"working_folder", order.working_folder.string()},
               {"scratch_folder", order.scratch_folder.string()},
               {"overwrite", order.overwrite},
               {"num_threads", order.num_threads},
               {"memory_bytes", order.memory_bytes},
               {"seconds", order.seconds},
               {"num_helpers", order.num_helpers},
               {"slices", Json::array()}};
  for (const auto& slice : order.slices) {
    Json tasks = Json::array();
    for (const OrderedTask& task : slice) tasks.push_back(ToJson(task));
    json["slices"].push_back(std::move(tasks));
  }
  WriteFileAtomically(batch_folder / kOrderFile,
                      json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

JobOrder ReadJobOrder(const fs::path& batch_folder) {
  const fs::path path = batch_folder / kOrderFile;
  std::ifstream file(path);
  if (!file) throw InputError(path.string(), "cannot be opened", "start the run again");
  try {
    return OrderFromJson(Json::parse(file));
  } catch (const std::exception& error) {
    throw InputError(path.string(), std::string("is not an order of jobs: ") + error.what(),
                     "start the run again");
  }
}

JobNumber ParseJobNumber(const std::string& text) {
  const size_t dot = text.find('.');
  JobNumber job{text.substr(0, dot), 0};
  const char* const end = text.data() + text.size();
  const char* const begin = dot == std::string::npos ? end : text.data() + dot + 1;
  const auto [rest, error] = std::from_chars(begin, end, job.slice);
  if (error == std::errc() && rest == end && !job.batch.empty()) return job;
  throw UsageError("--task is '" + text + "', but must be a batch and a job of it, such as 12.3");
}

}  // namespace lsmvs
