#include "lsmvs/execution/tasks/run_journal.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <optional>
#include <string>
#include <utility>

#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

void Apply(PublishingRecord publishing, RunRecord* record) {
  for (size_t i = 0; i < publishing.files.size(); ++i) {
    const FileTable::Entry& entry = publishing.files[i];
    record->files.SetMade(publishing.task.outputs[i], entry.hash, entry.stamp, entry.made_by);
  }
  record->tasks[publishing.name] = std::move(publishing.task);
}

std::optional<PublishingRecord> Parse(const std::string& line) {
  try {
    return PublishingFromText(line);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace

RunJournal::~RunJournal() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void RunJournal::Append(const PublishingRecord& publishing) {
  if (descriptor_ < 0) {
    descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  }
  if (descriptor_ < 0) throw FileSystemError(path_.string(), "create the file", errno);
  const std::string line = ToText(publishing) + "\n";
  for (size_t at = 0; at < line.size();) {
    const ssize_t written = ::write(descriptor_, line.data() + at, line.size() - at);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw FileSystemError(path_.string(), "write the file", errno);
    at += static_cast<size_t>(written);
  }
  if (::fdatasync(descriptor_) != 0) {
    throw FileSystemError(path_.string(), "write the file", errno);
  }
  num_bytes_ += line.size();
}

void RunJournal::Remove() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  num_bytes_ = 0;
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

bool RunJournal::Replay(const std::filesystem::path& path, RunRecord* record) {
  std::ifstream file(path);
  std::optional<PublishingRecord> last;
  for (std::string line; std::getline(file, line);) {
    std::optional<PublishingRecord> next = Parse(line);
    if (!next) continue;
    if (last) Apply(*std::move(last), record);
    last = std::move(next);
  }
  if (!last) return false;
  record->tasks.erase(last->name);  // were only some of the files renamed, they would not fit it
  record->publishing = std::move(last);
  return true;
}

}  // namespace lsmvs
