#include "lsmvs/execution/run_record.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>
#include <vector>

#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kFormat = 1;

// Puts a member behind the others. Json's operator[] looks through all of them for the name first,
// which takes time with the square of their number.
void Append(const std::string& name, Json value, Json* object) {
  object->get_ref<Json::object_t&>().emplace_back(name, std::move(value));
}

// "name=value" lines as an object, so that people can read them.
Json OptionsToJson(const std::string& options) {
  Json json = Json::object();
  std::istringstream lines(options);
  std::string line;
  while (std::getline(lines, line)) {
    const size_t split = line.find('=');
    if (split == std::string::npos) continue;
    json[line.substr(0, split)] = line.substr(split + 1);
  }
  return json;
}

std::string OptionsFromJson(const Json& json) {
  std::string options;
  for (const auto& [name, value] : json.items()) {
    options += name + "=" + value.get<std::string>() + "\n";
  }
  return options;
}

Json ToJson(const TaskRecord& task) {
  return {{"inputs_hash", task.inputs_hash}, {"outputs", task.outputs},
          {"seconds", task.seconds},         {"cpu_seconds", task.cpu_seconds},
          {"peak_bytes", task.peak_bytes},   {"num_threads", task.num_threads},
          {"finished", task.finished},       {"counts", task.counts},
          {"temporary", task.temporary}};
}

TaskRecord TaskFromJson(const Json& json) {
  TaskRecord task;
  task.inputs_hash = json.at("inputs_hash").get<std::string>();
  task.outputs = json.at("outputs").get<std::vector<std::string>>();
  task.seconds = json.at("seconds").get<double>();
  task.cpu_seconds = json.at("cpu_seconds").get<double>();
  task.peak_bytes = json.at("peak_bytes").get<uint64_t>();
  task.num_threads = json.at("num_threads").get<int>();
  task.finished = json.at("finished").get<std::string>();
  task.counts = json.at("counts").get<TaskCounts>();
  task.temporary = json.value("temporary", false);
  return task;
}

Json ToJson(const FileTable::Entry& entry) {
  Json json = {
      {"size", entry.stamp.size}, {"mtime_ns", entry.stamp.mtime_ns}, {"hash", entry.hash}};
  if (!entry.made_by.empty()) json["made_by"] = entry.made_by;
  return json;
}

FileTable::Entry EntryFromJson(const Json& json) {
  return {{json.at("size").get<uint64_t>(), json.at("mtime_ns").get<int64_t>()},
          json.at("hash").get<std::string>(),
          json.value("made_by", std::string())};
}

// Tasks of a stage that share version and options are one group; there is more than one only if
// some are stale.
Json* FindGroup(Json* groups, const std::string& version, const Json& options) {
  for (Json& group : *groups) {
    if (group["version"] == version && group["options"] == options) return &group;
  }
  groups->push_back({{"version", version},
                     {"options", options},
                     {"seconds", 0.0},
                     {"cpu_seconds", 0.0},
                     {"peak_bytes", uint64_t{0}},
                     {"counts", Json::object()},
                     {"tasks", Json::object()}});
  return &groups->back();
}

void AddToTotals(const TaskRecord& task, Json* group) {
  (*group)["seconds"] = (*group)["seconds"].get<double>() + task.seconds;
  (*group)["cpu_seconds"] = (*group)["cpu_seconds"].get<double>() + task.cpu_seconds;
  (*group)["peak_bytes"] = std::max((*group)["peak_bytes"].get<uint64_t>(), task.peak_bytes);
  for (const auto& [name, count] : task.counts) {
    (*group)["counts"][name] = (*group)["counts"].value(name, 0.0) + count;
  }
}

void AddTask(const std::string& name, const TaskRecord& task, Json* stages) {
  Json& groups = (*stages)[task.stage];
  if (groups.is_null()) groups = Json::array();
  Json* group = FindGroup(&groups, task.version, OptionsToJson(task.options));
  AddToTotals(task, group);
  Append(name, ToJson(task), &(*group)["tasks"]);
}

Json StagesToJson(const std::map<std::string, TaskRecord>& tasks) {
  Json stages = Json::object();
  for (const auto& [name, task] : tasks) AddTask(name, task, &stages);
  return stages;
}

Json ToJson(const PublishingRecord& publishing) {
  Json files = Json::array();
  for (const FileTable::Entry& entry : publishing.files) files.push_back(ToJson(entry));
  return {{"name", publishing.name},
          {"stage", publishing.task.stage},
          {"version", publishing.task.version},
          {"options", OptionsToJson(publishing.task.options)},
          {"task", ToJson(publishing.task)},
          {"files", files}};
}

PublishingRecord PublishingFromJson(const Json& json) {
  PublishingRecord publishing;
  publishing.name = json.at("name").get<std::string>();
  publishing.task = TaskFromJson(json.at("task"));
  publishing.task.stage = json.at("stage").get<std::string>();
  publishing.task.version = json.at("version").get<std::string>();
  publishing.task.options = OptionsFromJson(json.at("options"));
  for (const Json& entry : json.at("files")) publishing.files.push_back(EntryFromJson(entry));
  if (publishing.files.size() != publishing.task.outputs.size()) {
    throw std::invalid_argument("as many files as outputs expected");
  }
  return publishing;
}

// Reads a record. Takes tasks and files out of the text as they come, for the same reason as
// Append().
class RecordParser {
 public:
  explicit RecordParser(RunRecord* record) : record_(*record) {}

  void Parse(std::istream& text) {
    const Json json = Json::parse(text, [this](int depth, Json::parse_event_t event, Json& parsed) {
      return Take(static_cast<size_t>(depth), event, parsed);
    });
    if (json.at("format").get<int>() != kFormat) throw std::invalid_argument("unknown format");
    record_.program = json.at("program").get<std::string>();
    if (!json.contains("stages") || !json.contains("files")) {
      throw std::invalid_argument("stages or files are missing");
    }
    if (json.contains("publishing")) record_.publishing = PublishingFromJson(json["publishing"]);
  }

 private:
  // Depths in {"stages": {STAGE: [{"tasks": {TASK: {...}}}]}, "files": {FILE: {...}}}: of a name,
  // and of the object that it names.
  static constexpr size_t kTop = 1, kStage = 2, kGroup = 3, kOfGroup = 4, kTask = 5, kFile = 2;

  // Whether the parser is to keep what it has read.
  bool Take(size_t depth, Json::parse_event_t event, const Json& parsed) {
    if (event == Json::parse_event_t::key && depth < names_.size()) {
      names_[depth] = parsed.get<std::string>();
      for (size_t deeper = depth + 1; deeper < names_.size(); ++deeper) names_[deeper].clear();
    }
    if (event != Json::parse_event_t::object_end || depth == 0) return true;
    if (names_[kTop] == "files" && depth == kFile) {
      record_.files.entries().emplace(names_[kFile], EntryFromJson(parsed));
      return false;
    }
    if (names_[kTop] != "stages") return true;
    if (depth == kTask && names_[kOfGroup] == "tasks") {
      tasks_.emplace_back(names_[kTask], TaskFromJson(parsed));
      return false;
    }
    if (depth == kGroup) TakeGroup(parsed);
    return depth != kGroup;
  }

  void TakeGroup(const Json& group) {
    const auto version = group.at("version").get<std::string>();
    const std::string options = OptionsFromJson(group.at("options"));
    if (!group.at("tasks").empty()) throw std::invalid_argument("a task is no object");
    for (auto& [name, task] : tasks_) {
      task.stage = names_[kStage];
      task.version = version;
      task.options = options;
      record_.tasks.emplace(name, std::move(task));
    }
    tasks_.clear();
  }

  RunRecord& record_;
  std::array<std::string, kTask + 1> names_;               // by depth
  std::vector<std::pair<std::string, TaskRecord>> tasks_;  // of the group at hand
};

}  // namespace

std::string ToText(const PublishingRecord& publishing) {
  return ToJson(publishing).dump(-1, ' ', false, Json::error_handler_t::replace);
}

PublishingRecord PublishingFromText(const std::string& text) {
  return PublishingFromJson(Json::parse(text));
}

RunRecord ReadRunRecord(const std::filesystem::path& path, const std::filesystem::path& root) {
  RunRecord record(root);
  if (!std::filesystem::exists(path)) return record;
  std::ifstream file(path);
  try {
    RecordParser(&record).Parse(file);
  } catch (const std::exception& error) {
    throw InputError(path.string(),
                     std::string("is not a run record of this program: ") + error.what(),
                     "delete it to start anew; results that are there then count as yours");
  }
  return record;
}

void WriteRunRecord(const std::filesystem::path& path, const RunRecord& record) {
  Json json = {
      {"format", kFormat}, {"program", record.program}, {"stages", StagesToJson(record.tasks)}};
  Json& files = json["files"] = Json::object();
  for (const auto& [key, entry] : record.files.entries()) Append(key, ToJson(entry), &files);
  if (record.publishing) json["publishing"] = ToJson(*record.publishing);
  WriteFileAtomically(path, json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace lsmvs
