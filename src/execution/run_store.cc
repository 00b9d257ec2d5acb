#include "lsmvs/execution/run_store.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/hash.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "lsmvs";

fs::path RecordPath(const fs::path& root) { return root / kFolder / "run.json"; }
fs::path StagingFolder(const fs::path& root) { return root / kFolder / "staging"; }

bool HasBytes(const fs::path& path, const FileTable::Entry& entry) {
  return fs::exists(path) && StampOf(path).size == entry.stamp.size && HashFile(path) == entry.hash;
}

void Rename(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::create_directories(to.parent_path(), error);
  if (error) throw FileSystemError(to.parent_path().string(), "create the folder", error.value());
  fs::rename(from, to, error);
  if (error) throw FileSystemError(to.string(), "finish the file", error.value());
}

}  // namespace

RunStore::RunStore(const fs::path& root, const std::string& program)
    : root_(root),
      lock_(root / kFolder / "run.lock"),
      record_(ReadRunRecord(RecordPath(root), root)) {
  record_.program = program;
  FinishPublishing();
  std::error_code ignored;
  fs::remove_all(StagingFolder(root_), ignored);
}

RunStore::~RunStore() {
  std::error_code ignored;
  fs::remove_all(StagingFolder(root_), ignored);
}

fs::path RunStore::StagedPath(const fs::path& output) const {
  const fs::path key = record_.files.Key(output);
  if (key.is_relative()) return StagingFolder(root_) / key;
  return key.parent_path() / ".lsmvs-staging" / key.filename();
}

void RunStore::PrepareStaging(std::span<const fs::path> outputs) const {
  for (const fs::path& output : outputs) {
    const fs::path staged = StagedPath(output);
    std::error_code error;
    fs::remove(staged, error);
    fs::create_directories(staged.parent_path(), error);
    if (error) {
      throw FileSystemError(staged.parent_path().string(), "create the folder", error.value());
    }
  }
}

void RunStore::DropStaging(std::span<const fs::path> outputs) const {
  std::error_code ignored;
  for (const fs::path& output : outputs) {
    const fs::path staged = StagedPath(output);
    fs::remove(staged, ignored);
    fs::remove(staged.parent_path(), ignored);  // fails, as it should, while others are in it
  }
}

void RunStore::Publish(const std::string& name, std::span<const fs::path> outputs,
                       TaskRecord record) {
  PublishingRecord publishing{name, std::move(record), {}};
  for (const fs::path& output : outputs) {
    const fs::path staged = StagedPath(output);
    publishing.task.outputs.push_back(record_.files.Key(output));
    publishing.files.push_back({StampOf(staged), HashFile(staged), name});
  }
  record_.publishing = std::move(publishing);
  std::vector<std::string> old_keys;
  if (const auto old = record_.tasks.find(name); old != record_.tasks.end()) {
    old_keys = old->second.outputs;
    record_.tasks.erase(old);  // were only some of the files renamed, they would not fit it
  }
  Save();
  FinishPublishing();
  RemoveAbandoned(name, old_keys);
  DropStaging(outputs);
}

void RunStore::RemoveAbandoned(const std::string& name, const std::vector<std::string>& old_keys) {
  const auto found = record_.tasks.find(name);
  if (found == record_.tasks.end()) return;
  const std::vector<std::string>& keys = found->second.outputs;
  for (const std::string& key : old_keys) {
    const fs::path path = record_.files.PathOfKey(key);
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    std::error_code ignored;
    if (record_.files.MadeBy(path) == name) fs::remove(path, ignored);
  }
}

void RunStore::FinishPublishing() {
  if (!record_.publishing) return;
  const PublishingRecord publishing = *std::exchange(record_.publishing, std::nullopt);
  bool complete = true;
  for (size_t i = 0; i < publishing.files.size(); ++i) {
    const FileTable::Entry& entry = publishing.files[i];
    const std::string& key = publishing.task.outputs[i];
    const fs::path path = record_.files.PathOfKey(key);
    const fs::path staged = StagedPath(path);
    if (fs::exists(staged) && StampOf(staged) == entry.stamp) {
      Rename(staged, path);
    } else if (!HasBytes(path, entry)) {
      complete = false;
      continue;
    }
    record_.files.SetMade(key, entry.hash, entry.stamp, entry.made_by);
  }
  if (complete) record_.tasks[publishing.name] = publishing.task;
}

void RunStore::Save() { WriteRunRecord(RecordPath(root_), record_); }

}  // namespace lsmvs
