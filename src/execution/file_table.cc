#include "lsmvs/execution/file_table.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>

#include "lsmvs/util/error.h"
#include "lsmvs/util/hash.h"

namespace lsmvs {

namespace {

// Absolute, without "." and "..", and with links of existing folders followed.
std::filesystem::path Canonical(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::path canonical = std::filesystem::weakly_canonical(path, error);
  return error ? std::filesystem::absolute(path).lexically_normal() : canonical;
}

}  // namespace

FileStamp StampOf(const std::filesystem::path& path) {
  struct stat info = {};
  if (::stat(path.c_str(), &info) != 0) {
    throw InputError(path.string(), std::string("cannot be read: ") + std::strerror(errno),
                     "check that it exists");
  }
  constexpr int64_t kNanoseconds = 1'000'000'000;
  return {static_cast<uint64_t>(info.st_size),
          static_cast<int64_t>(info.st_mtim.tv_sec) * kNanoseconds + info.st_mtim.tv_nsec};
}

FileTable::FileTable(std::filesystem::path root) : root_(Canonical(root)) {}

std::string FileTable::Key(const std::filesystem::path& path) const {
  // The file itself may be a link: only its folder is resolved.
  const std::filesystem::path absolute =
      path.is_absolute() ? path : std::filesystem::absolute(path);
  const std::string& folder = FolderKey(absolute.parent_path());
  const std::string name = absolute.filename().generic_string();
  return folder.empty() ? name : (std::filesystem::path(folder) / name).generic_string();
}

// Following links takes a look at each folder of the path: once.
const std::string& FileTable::FolderKey(const std::filesystem::path& folder) const {
  const auto [entry, is_new] = folder_keys_.try_emplace(folder.native());
  if (!is_new) return entry->second;
  const std::filesystem::path whole = Canonical(folder);
  const std::filesystem::path relative = whole.lexically_relative(root_);
  const bool below = !relative.empty() && *relative.begin() != "..";
  if (!below) return entry->second = whole.generic_string();
  if (relative != ".") entry->second = relative.generic_string();
  return entry->second;
}

std::filesystem::path FileTable::PathOfKey(const std::string& key) const { return root_ / key; }

const std::string& FileTable::Hash(const std::filesystem::path& path) {
  const FileStamp stamp = StampOf(path);
  Entry& entry = entries_[Key(path)];
  if (!entry.hash.empty() && entry.stamp == stamp) return entry.hash;
  const std::string hash = HashFile(path);
  if (hash != entry.hash) entry.made_by.clear();
  entry.hash = hash;
  entry.stamp = stamp;
  return entry.hash;
}

std::string FileTable::MadeBy(const std::filesystem::path& path) {
  const auto found = entries_.find(Key(path));
  if (found == entries_.end() || found->second.made_by.empty()) return "";
  if (!std::filesystem::exists(path)) return "";
  Hash(path);
  return found->second.made_by;
}

std::string FileTable::RecordedHash(const std::filesystem::path& path) const {
  const auto found = entries_.find(Key(path));
  return found == entries_.end() ? std::string() : found->second.hash;
}

std::string FileTable::RecordedMaker(const std::filesystem::path& path) const {
  const auto found = entries_.find(Key(path));
  return found == entries_.end() ? std::string() : found->second.made_by;
}

void FileTable::SetMade(const std::string& key, const std::string& hash, const FileStamp& stamp,
                        const std::string& task) {
  entries_[key] = {stamp, hash, task};
}

}  // namespace lsmvs
