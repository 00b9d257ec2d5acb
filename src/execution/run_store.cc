#include "lsmvs/execution/run_store.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "lsmvs/execution/tasks/run_journal.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/hash.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "lsmvs";
constexpr size_t kMinJournalBytes = size_t{1} << 20;

fs::path RecordPath(const fs::path& root) { return root / kFolder / "run.json"; }
fs::path JournalPath(const fs::path& root) { return root / kFolder / "run.journal"; }
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

RunRecord ReadRecordOf(const fs::path& root) {
  RunRecord record = ReadRunRecord(RecordPath(root), root);
  RunJournal::Replay(JournalPath(root), &record);
  return record;
}

RunStore::RunStore(const fs::path& root, const std::string& program)
    : root_(root),
      lock_(root / kFolder / "run.lock"),
      record_(ReadRunRecord(RecordPath(root), root)),
      journal_(std::make_unique<RunJournal>(JournalPath(root))) {
  record_.program = program;
  const bool was_killed = RunJournal::Replay(JournalPath(root), &record_);
  FinishPublishing();
  std::error_code ignored;
  fs::remove_all(StagingFolder(root_), ignored);
  if (was_killed) Save();
}

RunStore::~RunStore() {
  std::error_code ignored;
  fs::remove_all(StagingFolder(root_), ignored);
  if (journal_->num_bytes() == 0) return;
  try {
    Save();
  } catch (const Error&) {
    // The journal stays.
  }
}

fs::path RunStore::StagedPath(const fs::path& output) const {
  const fs::path key = record_.files.Key(output);
  if (key.is_relative()) return StagingFolder(root_) / key;
  return key.parent_path() / ".lsmvs-staging" / key.filename();
}

void RunStore::Publish(const std::string& name, std::span<const fs::path> outputs,
                       TaskRecord record) {
  PublishingRecord publishing{name, std::move(record), {}};
  for (const fs::path& output : outputs) {
    const fs::path staged = StagedPath(output);
    publishing.task.outputs.push_back(record_.files.Key(output));
    publishing.files.push_back({StampOf(staged), HashFile(staged), name});
  }
  Publish(std::move(publishing));
}

void RunStore::Publish(const std::string& name, std::span<const fs::path> outputs,
                       std::span<const fs::path> staged, std::span<const std::string> hashes,
                       TaskRecord record) {
  PublishingRecord publishing{name, std::move(record), {}};
  publishing.task.outputs.clear();
  for (size_t i = 0; i < outputs.size(); ++i) {
    Rename(staged[i], StagedPath(outputs[i]));
    publishing.task.outputs.push_back(record_.files.Key(outputs[i]));
    publishing.files.push_back({StampOf(StagedPath(outputs[i])), hashes[i], name});
  }
  Publish(std::move(publishing));
}

void RunStore::Publish(PublishingRecord publishing) {
  const std::string name = publishing.name;
  record_.publishing = std::move(publishing);
  std::vector<std::string> old_keys;
  if (const auto old = record_.tasks.find(name); old != record_.tasks.end()) {
    old_keys = old->second.outputs;
    record_.tasks.erase(old);  // were only some of the files renamed, they would not fit it
  }
  journal_->Append(*record_.publishing);
  FinishPublishing();
  RemoveAbandoned(name, old_keys);
  if (journal_->num_bytes() > std::max(kMinJournalBytes, saved_bytes_)) Save();
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

void RunStore::Save() {
  WriteRunRecord(RecordPath(root_), record_);
  saved_bytes_ = StampOf(RecordPath(root_)).size;
  journal_->Remove();
}

}  // namespace lsmvs
