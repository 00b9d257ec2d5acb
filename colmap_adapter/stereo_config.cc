#include "lsmvs/colmap_adapter/stereo_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <unordered_map>
#include <unordered_set>

#include "lsmvs/colmap_adapter/files/text_reader.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

constexpr const char* kRemedy =
    "correct it or remove it to have it made again; see COLMAP's documentation of the format";

std::string_view Trim(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) + 1 - first);
}

// The parts between commas, without blanks around them; empty parts are dropped.
std::vector<std::string> SplitAtCommas(std::string_view text) {
  std::vector<std::string> parts;
  while (!text.empty()) {
    const size_t comma = std::min(text.find(','), text.size());
    const std::string_view part = Trim(text.substr(0, comma));
    if (!part.empty()) parts.emplace_back(part);
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return parts;
}

void ParseSources(const internal::TextReader& reader, PatchMatchProblem* problem) {
  const std::vector<std::string> parts = SplitAtCommas(reader.RestOfLine());
  if (parts.empty()) reader.Fail("names no source image");
  if (parts[0] == "__all__" && parts.size() == 1) {
    problem->sources = PatchMatchProblem::Sources::kAll;
  } else if (parts[0] == "__auto__") {
    const std::string count = parts.size() == 2 ? parts[1] : "";
    const char* end = count.data() + count.size();
    const auto [last, error] = std::from_chars(count.data(), end, problem->max_num_sources);
    if (error != std::errc() || last != end || problem->max_num_sources < 1) {
      reader.Fail("needs a number of images, as in '__auto__, 20'");
    }
  } else {
    problem->sources = PatchMatchProblem::Sources::kListed;
    problem->source_names = parts;
  }
}

std::string SourcesToText(const PatchMatchProblem& problem) {
  switch (problem.sources) {
    case PatchMatchProblem::Sources::kAuto:
      return fmt::format("__auto__, {}", problem.max_num_sources);
    case PatchMatchProblem::Sources::kAll:
      return "__all__";
    case PatchMatchProblem::Sources::kListed:
      break;
  }
  return fmt::format("{}", fmt::join(problem.source_names, ", "));
}

}  // namespace

std::vector<PatchMatchProblem> ReadPatchMatchConfig(const std::filesystem::path& path) {
  internal::TextReader reader(path, kRemedy);
  std::vector<PatchMatchProblem> problems;
  while (reader.NextContentLine()) {
    PatchMatchProblem problem;
    problem.reference_name = reader.RestOfLine();
    problem.reference_line = reader.line_number();
    if (!reader.NextContentLine()) {
      reader.Fail(fmt::format("ends after '{}' without naming its source images",
                              problem.reference_name.substr(0, 60)));
    }
    problem.source_line = reader.line_number();
    ParseSources(reader, &problem);
    problems.push_back(std::move(problem));
  }
  return problems;
}

bool AreColmapsDefault(const std::vector<PatchMatchProblem>& problems) {
  const int default_count = PatchMatchProblem().max_num_sources;
  return std::all_of(problems.begin(), problems.end(), [&](const PatchMatchProblem& problem) {
    return problem.sources == PatchMatchProblem::Sources::kAuto &&
           problem.max_num_sources == default_count;
  });
}

namespace {

class NameFinder {
 public:
  NameFinder(const Scene& scene, const std::filesystem::path& path) : path_(path.string()) {
    for (int v = 0; v < scene.num_views(); ++v) {
      view_of_name_[scene.views[static_cast<size_t>(v)].name] = v;
    }
  }

  int Find(const std::string& name, uint64_t line) const {
    const auto found = view_of_name_.find(name);
    if (found != view_of_name_.end()) return found->second;
    throw InputError(path_, fmt::format("line {}: the sparse model has no image '{}'", line, name),
                     "correct the name, or remove the file to have sources chosen");
  }

 private:
  const std::string path_;
  std::unordered_map<std::string, int> view_of_name_;
};

SourceRule ToRule(const PatchMatchProblem& problem, const NameFinder& finder) {
  SourceRule rule;
  switch (problem.sources) {
    case PatchMatchProblem::Sources::kAuto:
      rule.max_count = problem.max_num_sources;
      break;
    case PatchMatchProblem::Sources::kAll:
      rule.kind = SourceRule::Kind::kAll;
      break;
    case PatchMatchProblem::Sources::kListed:
      rule.kind = SourceRule::Kind::kListed;
      for (const std::string& name : problem.source_names) {
        rule.view_idxs.push_back(finder.Find(name, problem.source_line));
      }
      break;
  }
  return rule;
}

}  // namespace

std::vector<SourceRule> ToSourceRules(const std::vector<PatchMatchProblem>& problems,
                                      const Scene& scene, const std::filesystem::path& path) {
  const NameFinder finder(scene, path);
  std::vector<SourceRule> rules(scene.views.size(), {SourceRule::Kind::kNone, 0, {}});
  std::unordered_set<int> seen;
  for (const PatchMatchProblem& problem : problems) {
    const int view_idx = finder.Find(problem.reference_name, problem.reference_line);
    if (!seen.insert(view_idx).second) {
      throw InputError(path.string(),
                       fmt::format("line {}: '{}' is a reference for the second time",
                                   problem.reference_line, problem.reference_name),
                       "keep one of them");
    }
    rules[static_cast<size_t>(view_idx)] = ToRule(problem, finder);
  }
  return rules;
}

void WritePatchMatchConfig(const std::filesystem::path& path,
                           const std::vector<PatchMatchProblem>& problems) {
  std::string text;
  for (const PatchMatchProblem& problem : problems) {
    text += fmt::format("{}\n{}\n", problem.reference_name, SourcesToText(problem));
  }
  WriteFileAtomically(path, text);
}

std::vector<std::string> ReadFusionConfig(const std::filesystem::path& path) {
  internal::TextReader reader(path, kRemedy);
  std::vector<std::string> names;
  while (reader.NextContentLine()) names.emplace_back(reader.RestOfLine());
  return names;
}

void WriteFusionConfig(const std::filesystem::path& path, const std::vector<std::string>& names) {
  WriteFileAtomically(path, fmt::format("{}\n", fmt::join(names, "\n")));
}

}  // namespace lsmvs
