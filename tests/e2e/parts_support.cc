#include "parts_support.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

namespace lsmvs {

namespace fs = std::filesystem;

std::string ReadBytes(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void ExpectSameBytes(const fs::path& a, const fs::path& b) {
  EXPECT_TRUE(ReadBytes(a) == ReadBytes(b)) << a << " and " << b << " differ";
}

double CountOf(const fs::path& workspace, const std::string& stage, const fs::path& output,
               const std::string& name) {
  std::ifstream file(workspace / "lsmvs" / "run.json");
  const nlohmann::json record = nlohmann::json::parse(file);
  const std::string task = stage + " -> " + output.string();
  for (const auto& group : record.at("stages").at(stage)) {
    if (group.at("tasks").contains(task)) return group["tasks"][task].at("counts").at(name);
  }
  ADD_FAILURE() << task << " is not on record";
  return -1;
}

bool HasKept(const fs::path& scratch, const std::string& step) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(scratch, ignored)) {
    if (fs::exists(entry.path() / (step + ".finished"), ignored)) return true;
  }
  return false;
}

size_t CountCheckpoints(const fs::path& scratch) {
  size_t count = 0;
  for (const auto& entry : fs::directory_iterator(scratch)) {
    count += entry.path().filename().string().starts_with("lsmvs-steps-");
  }
  return count;
}

void KillBehindEach(const std::vector<std::string>& steps, const fs::path& scratch,
                    const std::function<ProgramResult(const ProgramOptions&)>& run) {
  for (const std::string& step : steps) {
    ProgramOptions options;
    options.signal_when = [&] { return HasKept(scratch, step); };
    EXPECT_EQ(run(options).signal, 9) << step;
    EXPECT_EQ(CountCheckpoints(scratch), 1u);
    EXPECT_TRUE(HasKept(scratch, step));
  }
  ExpectSuccess(run({}));
  EXPECT_EQ(CountCheckpoints(scratch), 0u);
}

}  // namespace lsmvs
