#include "lsmvs/program/parsing/ini_file.h"

#include <CLI/CLI.hpp>
#include <fstream>

#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

// The parser reports where a section begins and ends as items of these names.
bool IsSectionMark(const CLI::ConfigItem& item) { return item.name == "++" || item.name == "--"; }

std::vector<CLI::ConfigItem> ParseItems(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file || std::filesystem::is_directory(path)) {
    throw InputError(path.string(), "cannot be opened",
                     "give --project_path an ini file that exists");
  }
  try {
    CLI::ConfigINI parser;
    return parser.from_config(file);
  } catch (const CLI::Error& error) {
    throw InputError(path.string(), error.what(), "write key=value lines and [Group] sections");
  }
}

std::string FullName(const CLI::ConfigItem& item) {
  std::string name;
  for (const std::string& parent : item.parents) name += parent + ".";
  return name + item.name;
}

}  // namespace

std::vector<Assignment> ReadIniFile(const std::filesystem::path& path) {
  std::vector<Assignment> assignments;
  for (const CLI::ConfigItem& item : ParseItems(path)) {
    if (IsSectionMark(item)) continue;
    assignments.emplace_back(FullName(item), CLI::detail::join(item.inputs, " "));
  }
  return assignments;
}

}  // namespace lsmvs
