#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <unordered_map>

namespace lsmvs {

// Size and time of last change: as long as both stay, so do the bytes.
struct FileStamp {
  uint64_t size = 0;
  int64_t mtime_ns = 0;

  bool operator==(const FileStamp&) const = default;
};

// Stamp of an existing file. Throws InputError.
FileStamp StampOf(const std::filesystem::path& path);

// What is known of files: their hashes, so that big ones are read once, and which of them we made.
// Files below the root are known by their relative path, so that a folder may be moved; others by
// their absolute one.
class FileTable {
 public:
  struct Entry {
    FileStamp stamp;
    std::string hash;
    std::string made_by;  // name of our task, or empty
  };

  explicit FileTable(std::filesystem::path root);

  std::string Key(const std::filesystem::path& path) const;
  std::filesystem::path PathOfKey(const std::string& key) const;

  // Hash of the file as it is now; read from disk only if its stamp is not the one on record. A
  // file whose bytes are not those on record is not ours any more. Throws InputError if it cannot
  // be read.
  const std::string& Hash(const std::filesystem::path& path);
  // The task of ours that made the file, if it is there with the bytes that were made; else empty.
  std::string MadeBy(const std::filesystem::path& path);
  // Hash on record, of a file that may be gone; empty if none is.
  std::string RecordedHash(const std::filesystem::path& path) const;
  // The task of ours on record as maker of a file that may be gone; empty if none is.
  std::string RecordedMaker(const std::filesystem::path& path) const;

  // Records that `task` made the file, which has this hash and stamp.
  void SetMade(const std::string& key, const std::string& hash, const FileStamp& stamp,
               const std::string& task);

  std::map<std::string, Entry>& entries() { return entries_; }
  const std::map<std::string, Entry>& entries() const { return entries_; }

 private:
  const std::string& FolderKey(const std::filesystem::path& folder) const;

  std::filesystem::path root_;
  // Of folders that were asked for: relative to the root, empty for itself, or absolute.
  mutable std::unordered_map<std::string, std::string> folder_keys_;
  std::map<std::string, Entry> entries_;
};

}  // namespace lsmvs
