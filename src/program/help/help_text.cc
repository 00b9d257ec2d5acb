#include "lsmvs/program/help/help_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>

#include "lsmvs/program/version.h"

namespace lsmvs {

namespace {

std::string GroupOf(const std::string& name) {
  const size_t dot = name.find('.');
  return dot == std::string::npos ? std::string() : name.substr(0, dot);
}

// With a capital at the start and a full stop at the end.
std::string Sentence(std::string text) {
  if (text.empty()) return text;
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  if (text.back() != '.') text += '.';
  return text;
}

std::string EntryHelp(const OptionSet::Entry& entry, bool required) {
  const std::string value = entry.type == "BOOL" ? "0|1" : entry.type;
  return fmt::format("  --{} {}{}\n{}", entry.name, value, required ? "  (required)" : "",
                     Wrap(EntryText(entry), 6));
}

std::string GroupHelp(const std::string& title, const OptionSet& options, const std::string& group,
                      const std::vector<std::string>& required) {
  std::string text;
  for (const OptionSet::Entry& entry : options.entries()) {
    if (GroupOf(entry.name) != group) continue;
    const bool is_required =
        std::find(required.begin(), required.end(), entry.name) != required.end();
    text += EntryHelp(entry, is_required);
  }
  return text.empty() ? text : fmt::format("\n{}:\n{}", title, text);
}

// The first sentence of an option's help, and its default.
std::string ShortText(const OptionSet::Entry& entry) {
  const std::string help = Sentence(entry.help);
  std::string text = help.substr(0, help.find(". "));
  if (text.back() != '.') text += '.';
  if (!entry.default_value.empty()) text += fmt::format(" [{}]", entry.default_value);
  return text;
}

// "  NAME   text", the text wrapped in its own column.
std::string ShortEntry(const std::string& name, const std::string& text) {
  constexpr size_t kColumn = 30;
  std::string wrapped = Wrap(text, kColumn);
  const std::string head = "  " + name;
  if (head.size() + 2 > kColumn) return head + "\n" + wrapped;
  return wrapped.replace(0, head.size(), head);
}

std::string ShortOptions(const OptionSet& options, const std::vector<std::string>& required) {
  std::string first, others;
  for (const OptionSet::Entry& entry : options.entries()) {
    const bool is_required =
        std::find(required.begin(), required.end(), entry.name) != required.end();
    if (!GroupOf(entry.name).empty() || (entry.is_rare && !is_required)) continue;
    const std::string value = entry.type == "BOOL" ? "0|1" : entry.type;
    (is_required ? first : others) +=
        ShortEntry(fmt::format("--{} {}", entry.name, value),
                   ShortText(entry) + (is_required ? " Required." : ""));
  }
  return first + others;
}

// "--a --b": those that `counts`.
template <class Counts>
std::string Names(const OptionSet& options, const Counts& counts) {
  std::vector<std::string> names;
  for (const OptionSet::Entry& entry : options.entries()) {
    if (counts(entry)) names.push_back("--" + entry.name);
  }
  return fmt::format("{}", fmt::join(names, " "));
}

std::vector<std::string> GroupsInOrder(const OptionSet& options) {
  std::vector<std::string> groups;
  for (const OptionSet::Entry& entry : options.entries()) {
    const std::string group = GroupOf(entry.name);
    if (group.empty()) continue;
    if (std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
  }
  return groups;
}

std::string Usage(const std::string& program, const CommandInfo& info) {
  std::string line = "Usage: " + program;
  if (!info.positional.empty()) line += " WORKSPACE";
  for (const std::string& name : info.required) {
    if (name != info.positional) line += fmt::format(" --{} ...", name);
  }
  return line + " [options]\n";
}

}  // namespace

std::string EntryText(const OptionSet::Entry& entry) {
  std::string text = Sentence(entry.help);
  if (entry.is_list()) text += " May be given several times.";
  if (!entry.bounds.empty()) text += fmt::format(" Allowed: {}.", entry.bounds);
  if (!entry.default_value.empty()) text += fmt::format(" Default: {}.", entry.default_value);
  return text;
}

std::string Wrap(const std::string& text, size_t indent, size_t width) {
  std::string result;
  std::istringstream paragraphs(text);
  std::string paragraph;
  while (std::getline(paragraphs, paragraph)) {
    std::istringstream words(paragraph);
    std::string line(indent, ' '), word;
    while (words >> word) {
      if (line.size() > indent && line.size() + 1 + word.size() > width) {
        result += line + "\n";
        line.assign(indent, ' ');
      }
      if (line.size() > indent) line += ' ';
      line += word;
    }
    result += (line.size() > indent ? line : "") + "\n";
  }
  return result;
}

std::string ExitCodeHelp() {
  return "\nExit codes:\n"
         "  0    success\n"
         "  1    a bug in the program; please report it\n"
         "  2    unknown option or a value out of range\n"
         "  3    an input file is missing, corrupt or does not fit the others\n"
         "  4    a file cannot be written: read-only, no permission, or the disk is full or too "
         "small "
         "for the results\n"
         "  5    the work does not fit into the memory\n"
         "  6    a file that this program did not make is in the way; --overwrite replaces it\n"
         "  7    the `colmap` executable or the job system (--engine) is missing or failed\n"
         "  130  stopped by Ctrl-C or SIGTERM; finished work is kept and the next run goes on from "
         "there\n";
}

namespace {

std::string Introduction(const std::string& program, const CommandInfo& info) {
  std::string text = fmt::format("{}: {}\n\n{}", program, info.summary, Usage(program, info));
  text += fmt::format("\n{}", Wrap(info.details, 0));
  if (!info.examples.empty()) text += "\nExamples:\n";
  for (const std::string& example : info.examples) text += fmt::format("  {}\n", example);
  return text;
}

std::string ShortHelp(const std::string& program, const CommandInfo& info,
                      const OptionSet& own_options, const OptionSet& common_options) {
  std::string text = Introduction(program, info) + "\nOptions [default]:\n";
  text += ShortOptions(own_options, info.required);
  const std::string rare = Names(own_options, [](const auto& entry) { return entry.is_rare; });
  if (!rare.empty()) text += "\n" + Wrap("Rarely needed: " + rare, 0);
  text += "\n" +
          Wrap("Of every command: " + Names(common_options, [](const auto&) { return true; }), 0);
  const std::vector<std::string> groups = GroupsInOrder(own_options);
  return text + Wrap(groups.empty() ? "--help_all tells more of each option."
                                    : fmt::format("--help_all tells more of each option, and shows "
                                                  "those of {}.",
                                                  fmt::join(groups, ", ")),
                     0);
}

std::string FullHelp(const std::string& program, const CommandInfo& info,
                     const OptionSet& own_options, const OptionSet& common_options) {
  std::string text = Introduction(program, info);
  text += GroupHelp("Options", own_options, "", info.required);
  text += GroupHelp("Common options", common_options, "", {});
  text +=
      "  -h, --help\n      Prints the main options.\n"
      "  --help_all\n      Prints this text.\n  --version\n      Prints the version.\n";
  for (const std::string& group : GroupsInOrder(own_options)) {
    text += GroupHelp(group, own_options, group, {});
  }
  if (!info.without_meaning.empty()) {
    text += fmt::format("\nTaken from COLMAP's scripts, with a warning, and without effect:\n{}",
                        Wrap(fmt::format("--{}", fmt::join(info.without_meaning, " --")), 2));
  }
  return text + ExitCodeHelp();
}

}  // namespace

std::string CommandHelp(const std::string& program, const CommandInfo& info,
                        const OptionSet& own_options, const OptionSet& common_options, bool all) {
  return (all ? FullHelp : ShortHelp)(program, info, own_options, common_options);
}

std::string OverviewHelp(const std::vector<CommandFactory>& commands) {
  std::string text =
      "lsmvs: dense multi-view stereo and meshing for COLMAP workspaces\n\n"
      "Usage: lsmvs COMMAND [options]\n"
      "       lsmvs COMMAND --help          its main options; --help_all: all of them\n"
      "       lsmvs-mesher WORKSPACE        runs every step that leads from photos to a mesh\n\n"
      "Commands:\n";
  for (const CommandFactory& make : commands) {
    const CommandInfo info = make()->Info();
    if (!info.is_internal) text += fmt::format("  {:<22} {}\n", info.name, info.summary);
  }
  return text + ExitCodeHelp();
}

std::string VersionLine() { return "lsmvs " LSMVS_VERSION; }

}  // namespace lsmvs
