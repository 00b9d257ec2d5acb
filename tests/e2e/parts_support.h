#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "program_runner.h"

// For tests of stages that work in parts.

namespace lsmvs {

std::string ReadBytes(const std::filesystem::path& path);
void ExpectSameBytes(const std::filesystem::path& a, const std::filesystem::path& b);

// A count that the run of `stage` that made `output` put on the workspace's record.
double CountOf(const std::filesystem::path& workspace, const std::string& stage,
               const std::filesystem::path& output, const std::string& name);

// Whether some run has kept the results of the step in the folder of scratch files.
bool HasKept(const std::filesystem::path& scratch, const std::string& step);
// Runs that have kept something there.
size_t CountCheckpoints(const std::filesystem::path& scratch);

// Starts a run in parts again and again, killed behind one step after the other; the last start
// comes to its end, and nothing is left in the folder of scratch files.
void KillBehindEach(const std::vector<std::string>& steps, const std::filesystem::path& scratch,
                    const std::function<ProgramResult(const ProgramOptions&)>& run);

}  // namespace lsmvs
