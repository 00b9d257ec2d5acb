#include "lsmvs/adapter_test/corruption.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <random>

#include "lsmvs/util/error.h"

namespace lsmvs {

std::string ReadWholeFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

void WriteWholeFile(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  EXPECT_TRUE(file) << path;
}

void ExpectErrorAtEveryTruncation(const std::filesystem::path& path,
                                  const std::function<void()>& read) {
  const std::string bytes = ReadWholeFile(path);
  for (size_t length = 0; length < bytes.size(); ++length) {
    WriteWholeFile(path, bytes.substr(0, length));
    try {
      read();
      ADD_FAILURE() << path << " cut to " << length << " bytes was accepted";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos) << error.what();
    }
  }
  WriteWholeFile(path, bytes);
}

void ExpectSurvivesMutations(const std::filesystem::path& path, int num_rounds,
                             const std::function<void()>& read) {
  const std::string bytes = ReadWholeFile(path);
  std::mt19937 random(1);
  for (int round = 0; round < num_rounds; ++round) {
    std::string changed = bytes;
    const int num_changes = 1 + static_cast<int>(random() % 4);
    for (int i = 0; i < num_changes; ++i) {
      changed[random() % changed.size()] = static_cast<char>(random());
    }
    WriteWholeFile(path, changed);
    try {
      read();
    } catch (const InputError&) {
    }
  }
  WriteWholeFile(path, bytes);
}

std::string InputErrorOf(const std::function<void()>& read) {
  try {
    read();
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no InputError";
  return "";
}

}  // namespace lsmvs
