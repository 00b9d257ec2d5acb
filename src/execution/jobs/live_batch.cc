#include "lsmvs/execution/jobs/live_batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>

#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

// Of a folder that is named by a number, else nothing.
std::optional<size_t> NumberOf(const fs::path& folder) {
  const std::string name = folder.filename().string();
  size_t number = 0;
  const char* const end = name.data() + name.size();
  const auto [rest, error] = std::from_chars(name.data(), end, number);
  if (error != std::errc() || rest != end) return std::nullopt;
  return number;
}

}  // namespace

size_t LiveSlice::FirstOpen() const {
  const auto open = std::find(is_collected.begin(), is_collected.end(), false);
  return static_cast<size_t>(open - is_collected.begin());
}

size_t LiveBatch::NumOpen() const {
  return static_cast<size_t>(std::count_if(slices.begin(), slices.end(),
                                           [](const LiveSlice& slice) { return slice.is_open(); }));
}

JobBatch LiveBatch::ToJobBatch(const std::string& program, const fs::path& root) const {
  JobBatch batch;
  batch.name = order.batch_name;
  batch.folder = folder;
  batch.num_jobs = slices.size() + order.num_helpers;
  batch.command = {program, "run_task", fs::absolute(root).string(), "--task",
                   folder.filename().string() + "."};
  batch.num_threads = order.num_threads;
  batch.memory_bytes = order.memory_bytes;
  batch.seconds = order.seconds;
  return batch;
}

fs::path MakeBatchFolder(const fs::path& root, const JobOrder& order) {
  const std::vector<fs::path> folders = FindBatchFolders(root);
  size_t number = folders.empty() ? 1 : *NumberOf(folders.back()) + 1;
  const fs::path jobs = fs::absolute(JobsFolder(root));
  std::error_code error;
  fs::create_directories(jobs, error);
  while (!error && !fs::create_directory(jobs / fmt::format("{}", number), error)) ++number;
  const fs::path folder = jobs / fmt::format("{}", number);
  for (size_t i = 0; i < order.slices.size() && !error; ++i) {
    fs::create_directory(SliceFolder(folder, i), error);
  }
  if (error) throw FileSystemError(folder.string(), "create the folder", error.value());
  WriteJobOrder(folder, order);
  return folder;
}

void WriteHandle(const fs::path& batch_folder, const std::string& handle) {
  WriteFileAtomically(batch_folder / "handle", handle + "\n");
}

std::optional<std::string> ReadHandle(const fs::path& batch_folder) {
  std::ifstream file(batch_folder / "handle");
  std::string handle;
  if (!std::getline(file, handle) || handle.empty()) return std::nullopt;
  return handle;
}

void MarkAbandoned(const fs::path& batch_folder) { std::ofstream(batch_folder / "abandoned"); }

bool IsAbandoned(const fs::path& batch_folder) { return fs::exists(batch_folder / "abandoned"); }

std::vector<fs::path> FindBatchFolders(const fs::path& root) {
  std::error_code error;
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(fs::absolute(JobsFolder(root)), error)) {
    if (NumberOf(entry.path())) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end(),
            [](const fs::path& a, const fs::path& b) { return *NumberOf(a) < *NumberOf(b); });
  return folders;
}

}  // namespace lsmvs
