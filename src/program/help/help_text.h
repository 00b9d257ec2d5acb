#pragma once

#include <string>
#include <vector>

#include "lsmvs/program/command.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

// Breaks `text` into lines of at most `width` characters, each indented by `indent` spaces; keeps
// the line breaks that are there.
std::string Wrap(const std::string& text, size_t indent, size_t width = 96);

// Meaning, bounds and default of an option: what --help_all says of it.
std::string EntryText(const OptionSet::Entry& entry);

// `program` is what is typed before the options: "lsmvs stereo_fusion". Fits a screen: the options
// without a group, a line or two each; with `all` every option with its bounds, and the exit codes.
std::string CommandHelp(const std::string& program, const CommandInfo& info,
                        const OptionSet& own_options, const OptionSet& common_options, bool all);

// Help of `lsmvs` itself: the list of commands.
std::string OverviewHelp(const std::vector<CommandFactory>& commands);

// The table of exit codes, as printed by --help_all.
std::string ExitCodeHelp();

}  // namespace lsmvs
