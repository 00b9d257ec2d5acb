#include "lsmvs/program/manual.h"

#include <fmt/format.h>

#include <sstream>

#include "lsmvs/program/help/help_text.h"
#include "lsmvs/program/parsing/common_options.h"
#include "lsmvs/program/version.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

namespace {

// A command with its option tables.
struct Page {
  explicit Page(const CommandFactory& make) : command(make()), info(command->Info()) {
    command->Describe(&options);
    common.Describe(&options);
  }

  std::unique_ptr<Command> command;
  CommandInfo info;
  CommonOptions common;
  OptionSet options;
};

// Text that roff takes as it is: no escapes, no requests, hyphens that can be copied.
std::string Roff(const std::string& text) {
  std::string escaped;
  bool at_line_begin = true;
  for (const char c : text) {
    if (at_line_begin && (c == '.' || c == '\'')) escaped += "\\&";
    if (c == '\\' || c == '-') escaped += '\\';
    escaped += c == '\\' ? std::string("e") : std::string(1, c);
    at_line_begin = c == '\n';
  }
  return escaped;
}

std::string Paragraphs(const std::string& text) {
  std::string result;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) result += ".PP\n" + Roff(line) + "\n";
  return result;
}

std::string Head(const std::string& name, const std::string& summary) {
  return fmt::format(".TH {} 1 \"\" \"{}\" \"User commands\"\n.SH NAME\n{} \\- {}\n", name,
                     VersionLine(), Roff(name), Roff(summary));
}

std::string ExitSection() {
  return ".SH EXIT STATUS\n.nf\n" + Roff(ExitCodeHelp().substr(sizeof("\nExit codes:"))) + ".fi\n";
}

std::string ManPage(const std::string& name, const std::string& typed, const Page& page) {
  std::string text = Head(name, page.info.summary);
  text += fmt::format(".SH SYNOPSIS\n.B {}\n{}[\\fIoptions\\fR]\n", Roff(typed),
                      page.info.positional.empty() ? "" : "\\fIWORKSPACE\\fR ");
  text += ".SH DESCRIPTION\n" + Paragraphs(page.info.details);
  text += ".SH OPTIONS\n";
  for (const OptionSet::Entry& entry : page.options.entries()) {
    text += fmt::format(".TP\n\\fB{}\\fR \\fI{}\\fR\n{}\n", Roff("--" + entry.name),
                        Roff(entry.type == "BOOL" ? "0|1" : entry.type), Roff(EntryText(entry)));
  }
  if (!page.info.examples.empty()) text += ".SH EXAMPLES\n.nf\n";
  for (const std::string& example : page.info.examples) text += Roff(example) + "\n";
  if (!page.info.examples.empty()) text += ".fi\n";
  return text + ExitSection();
}

std::string OverviewPage(const std::vector<CommandFactory>& commands) {
  std::string text = Head("lsmvs", "dense multi-view stereo and meshing for COLMAP workspaces");
  text += ".SH SYNOPSIS\n.B lsmvs\n\\fICOMMAND\\fR [\\fIoptions\\fR]\n.SH COMMANDS\n";
  for (const CommandFactory& make : commands) {
    const CommandInfo info = make()->Info();
    text += fmt::format(".TP\n.BR lsmvs\\-{} (1)\n{}\n", Roff(info.name), Roff(info.summary));
  }
  return text + ExitSection() + ".SH SEE ALSO\n.BR lsmvs\\-mesher (1)\n";
}

std::string OptionNames(const Page& page) {
  std::string names;
  for (const OptionSet::Entry& entry : page.options.entries()) names += " --" + entry.name;
  return names.substr(1) + " --help --help_all --version";
}

// Options by the command that stands first; a value is completed as a file name.
std::string BashCompletion(const std::vector<CommandFactory>& commands, const Page& mesher) {
  std::string names, cases;
  for (const CommandFactory& make : commands) {
    const Page page(make);
    names += " " + page.info.name;
    cases += fmt::format("    {}) words=\"{}\" ;;\n", page.info.name, OptionNames(page));
  }
  return fmt::format(
      "# Completion of lsmvs and lsmvs-mesher in bash.\n"
      "_lsmvs() {{\n"
      "  local current=${{COMP_WORDS[COMP_CWORD]}} words=\n"
      "  case ${{COMP_WORDS[0]##*/}}:${{COMP_WORDS[1]}} in\n"
      "    lsmvs-mesher:*) words=\"{}\" ;;\n"
      "    *) [ \"$COMP_CWORD\" -eq 1 ] && words=\"help{}\" ;;\n"
      "  esac\n"
      "  [ -n \"$words\" ] || case ${{COMP_WORDS[1]}} in\n{}  esac\n"
      "  COMPREPLY=()\n"
      "  if [[ $current == -* || ($COMP_CWORD -eq 1 && $words == help*) ]]; then\n"
      "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
      "  fi\n"
      "}}\n"
      "complete -o default -F _lsmvs lsmvs lsmvs-mesher\n",
      OptionNames(mesher), names, cases);
}

}  // namespace

std::vector<ManualFile> MakeManual(const std::vector<CommandFactory>& commands,
                                   const CommandFactory& make_mesher) {
  const Page mesher(make_mesher);
  const std::string completion = BashCompletion(commands, mesher);
  std::vector<ManualFile> files = {
      {"man/man1/lsmvs.1", OverviewPage(commands)},
      {"man/man1/lsmvs-mesher.1", ManPage("lsmvs-mesher", "lsmvs-mesher", mesher)},
      {"bash-completion/completions/lsmvs", completion},
      {"bash-completion/completions/lsmvs-mesher", completion}};
  for (const CommandFactory& make : commands) {
    const Page page(make);
    files.push_back({fmt::format("man/man1/lsmvs-{}.1", page.info.name),
                     ManPage("lsmvs-" + page.info.name, "lsmvs " + page.info.name, page)});
  }
  return files;
}

}  // namespace lsmvs
