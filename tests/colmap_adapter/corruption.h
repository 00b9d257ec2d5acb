#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace lsmvs {

std::string ReadWholeFile(const std::filesystem::path& path);
void WriteWholeFile(const std::filesystem::path& path, const std::string& bytes);

// Cuts the file at every byte and expects `read` to throw InputError, naming the file, each time.
// Restores the file.
void ExpectErrorAtEveryTruncation(const std::filesystem::path& path,
                                  const std::function<void()>& read);

// Changes 1 to 4 bytes at random (fixed seed), `num_rounds` times, and expects `read` to do its
// work or to throw InputError, nothing else. Restores the file.
void ExpectSurvivesMutations(const std::filesystem::path& path, int num_rounds,
                             const std::function<void()>& read);

// The message of the InputError that `read` throws; fails the test if it does not.
std::string InputErrorOf(const std::function<void()>& read);

}  // namespace lsmvs
