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

}  // namespace lsmvs
