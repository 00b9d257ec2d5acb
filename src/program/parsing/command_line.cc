#include "lsmvs/program/parsing/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <set>

#include "lsmvs/util/error.h"
#include "lsmvs/util/nearest_name.h"

namespace lsmvs {

namespace {

std::vector<std::string> NamesOf(const OptionSet& options) {
  std::vector<std::string> names = {"help", "help_all", "version"};
  for (const OptionSet::Entry& entry : options.entries()) names.push_back(entry.name);
  return names;
}

std::string UnknownOption(const std::string& name, const OptionSet& options) {
  const std::string nearest = NearestOption(name, NamesOf(options));
  if (nearest.empty()) return fmt::format("unknown option --{}; see --help", name);
  return fmt::format("unknown option --{}; did you mean --{}?", name, nearest);
}

bool IsBoolText(const std::string& text) {
  static const std::set<std::string> texts = {"0", "1", "true", "false", "yes", "no", "on", "off"};
  return texts.contains(text);
}

bool IsIn(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Leaves out options without meaning and their values, and puts their names into `found`.
std::vector<std::string> LeaveOutMeaningless(const std::vector<std::string>& arguments,
                                             const std::vector<std::string>& without_meaning,
                                             std::set<std::string>* found) {
  std::vector<std::string> kept;
  for (size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    const size_t equals = argument.find('=');
    const bool is_long = argument.starts_with("--");
    const std::string name = is_long ? argument.substr(2, equals - 2) : "";
    if (!IsIn(without_meaning, name)) {
      kept.push_back(argument);
      continue;
    }
    found->insert(name);
    const bool has_next = i + 1 < arguments.size() && !arguments[i + 1].starts_with("--");
    if (equals == std::string::npos && has_next) ++i;
  }
  return kept;
}

// "--name value" as "--name=value", so that a value may start with '-' and a flag never swallows
// the next argument.
std::vector<std::string> JoinValues(const std::vector<std::string>& arguments,
                                    const OptionSet& options, const OptionSynonyms& synonyms) {
  std::vector<std::string> joined;
  for (size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    const bool is_long = argument.starts_with("--") && argument.find('=') == std::string::npos;
    const OptionSet::Entry* entry =
        is_long ? options.Find(synonyms.Canonical(argument.substr(2))) : nullptr;
    if (entry == nullptr) {
      joined.push_back(argument);
      continue;
    }
    const bool has_next = i + 1 < arguments.size();
    const bool takes_next =
        has_next && (entry->type == "BOOL" ? IsBoolText(arguments[i + 1])
                                           : !arguments[i + 1].starts_with("--"));
    if (takes_next) {
      joined.push_back(argument + "=" + arguments[++i]);
    } else {
      joined.push_back(entry->type == "BOOL" ? argument + "=1" : argument);
    }
  }
  return joined;
}

// Turns the parser's complaint into ours.
[[noreturn]] void Complain(const CLI::ParseError& error, const CLI::App& app,
                           const OptionSet& options) {
  for (const std::string& extra : app.remaining()) {
    if (!extra.starts_with("-")) {
      throw UsageError(fmt::format("unexpected argument '{}'; see --help", extra));
    }
    const std::string name = extra.substr(extra.find_first_not_of('-'));
    throw UsageError(UnknownOption(name.substr(0, name.find('=')), options));
  }
  throw UsageError(std::string(error.what()) + "; see --help");
}

bool HasGroup(const std::string& name) { return name.find('.') != std::string::npos; }

std::set<std::string> GroupsOf(const OptionSet& options) {
  std::set<std::string> groups;
  for (const OptionSet::Entry& entry : options.entries()) {
    if (HasGroup(entry.name)) groups.insert(entry.name.substr(0, entry.name.find('.')));
  }
  return groups;
}

// Known assignments of the ini file; sections of other commands go to `ignored`.
std::vector<Assignment> KeepKnown(const std::vector<Assignment>& assignments,
                                  const OptionSet& options, const OptionSynonyms& synonyms,
                                  std::set<std::string>* ignored) {
  const std::set<std::string> groups = GroupsOf(options);
  std::vector<Assignment> kept;
  for (const auto& [name, text] : assignments) {
    const std::string group = HasGroup(name) ? name.substr(0, name.find('.')) : "";
    if (options.Find(synonyms.Canonical(name)) != nullptr) {
      kept.emplace_back(name, text);
    } else if (!group.empty() && !groups.contains(group)) {
      ignored->insert(group);
    } else if (synonyms.common_keys.contains(name)) {
      continue;
    } else {
      throw UsageError(UnknownOption(name, options) + " (from the ini file)");
    }
  }
  return kept;
}

// Values of a list replace those that it had before.
void SetAll(const std::vector<Assignment>& assignments, const OptionSet& options,
            const OptionSynonyms& synonyms, bool grouped) {
  std::set<const OptionSet::Entry*> begun;
  for (const auto& [name, text] : assignments) {
    if (HasGroup(name) != grouped || synonyms.MeansDefault(name, text)) continue;
    const OptionSet::Entry* entry = options.Find(synonyms.Canonical(name));
    if (entry->is_list() && begun.insert(entry).second) entry->clear();
    entry->set(text);
  }
}

}  // namespace

CommandLine ParseCommandLine(const std::vector<std::string>& arguments, const OptionSet& options,
                             const std::string& positional,
                             const std::vector<std::string>& without_meaning,
                             const OptionSynonyms& synonyms) {
  CommandLine line;
  CLI::App app;
  app.set_help_flag();
  app.add_flag("-h,--help", line.help);
  app.add_flag("--help_all,--help-all", line.help_all);
  app.add_flag("--version", line.version);
  for (const OptionSet::Entry& entry : options.entries()) {
    std::string names = "--" + entry.name;
    for (const auto& [synonym, name] : synonyms.names) {
      if (name == entry.name) names += ",--" + synonym;
    }
    if (entry.name == positional) names += "," + positional;
    const auto assign = [&line, name = entry.name](const std::vector<std::string>& texts) {
      for (const std::string& text : texts) line.assignments.emplace_back(name, text);
    };
    CLI::Option* option = app.add_option_function<std::vector<std::string>>(names, assign);
    option->allow_extra_args(false);  // one value each time it is given
    if (!entry.is_list()) option->take_last()->expected(1);
  }
  std::vector<std::string> reversed = JoinValues(
      LeaveOutMeaningless(arguments, without_meaning, &line.without_meaning), options, synonyms);
  std::reverse(reversed.begin(), reversed.end());
  try {
    app.parse(reversed);
  } catch (const CLI::ParseError& error) {
    if (!line.help && !line.help_all) Complain(error, app, options);
  }
  return line;
}

std::vector<std::string> ApplyAssignments(const std::vector<Assignment>& ini_assignments,
                                          const std::vector<Assignment>& line_assignments,
                                          const OptionSet& options,
                                          const std::function<void()>& apply_presets,
                                          const OptionSynonyms& synonyms) {
  std::set<std::string> ignored;
  const std::vector<Assignment> from_ini = KeepKnown(ini_assignments, options, synonyms, &ignored);
  for (const bool grouped : {false, true}) {
    if (grouped) apply_presets();
    SetAll(from_ini, options, synonyms, grouped);
    SetAll(line_assignments, options, synonyms, grouped);
  }
  return {ignored.begin(), ignored.end()};
}

void TakeOutMeaningless(const std::vector<std::string>& without_meaning,
                        std::vector<Assignment>* assignments, std::set<std::string>* names) {
  std::erase_if(*assignments, [&](const Assignment& assignment) {
    if (!IsIn(without_meaning, assignment.first)) return false;
    names->insert(assignment.first);
    return true;
  });
}

}  // namespace lsmvs
