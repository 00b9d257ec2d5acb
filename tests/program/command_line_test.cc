#include "lsmvs/program/parsing/command_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "lsmvs/program/help/help_text.h"
#include "lsmvs/program/parsing/common_options.h"
#include "lsmvs/program/run_program.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/duration_text.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

using testing::HasSubstr;
using testing::Not;

struct Options {
  std::string workspace;
  bool overwrite = false;
  int size = 10;
  double error = 0.5;
  int group_size = 1;

  void Describe(OptionSet* set) {
    set->Add("workspace_path", &workspace, "Folder.");
    set->Add("overwrite", &overwrite, "Replace files.");
    set->Add("max_image_size", &size, "Pixels.", {-1, 100});
    set->Add("Group.max_error", &error, "Pixels.", {0.0, 1.0});
    set->Add("Group.size", &group_size, "Pixels.");
  }
};

struct Parsed {
  Options options;
  CommandLine line;
};

Parsed Parse(const std::vector<std::string>& arguments) {
  Parsed parsed;
  OptionSet set;
  parsed.options.Describe(&set);
  parsed.line = ParseCommandLine(arguments, set, "workspace_path");
  ApplyAssignments({}, parsed.line.assignments, set, [&] { parsed.options.group_size = 7; });
  return parsed;
}

std::string UsageMessage(const std::vector<std::string>& arguments) {
  try {
    Parse(arguments);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "no error";
}

struct ListOptions {
  std::vector<std::string> inputs;
  bool overwrite = false;

  void Describe(OptionSet* set) {
    set->Add("input_path", &inputs, "Files.");
    set->Add("overwrite", &overwrite, "Replace files.");
  }
};

std::vector<std::string> ParseList(const std::vector<std::string>& arguments,
                                   const std::vector<Assignment>& ini = {}) {
  ListOptions options;
  OptionSet set;
  options.Describe(&set);
  const CommandLine line = ParseCommandLine(arguments, set, "input_path");
  ApplyAssignments(ini, line.assignments, set, [] {});
  return options.inputs;
}

TEST(CommandLine, ListsTakeAllValuesInOrder) {
  using testing::ElementsAre;
  EXPECT_THAT(
      ParseList({"--input_path", "b", "--overwrite", "--input_path=a", "--input_path", "c"}),
      ElementsAre("b", "a", "c"));
  EXPECT_THAT(ParseList({"x"}), ElementsAre("x"));
  EXPECT_THAT(ParseList({}), ElementsAre());
  EXPECT_THAT(ParseList({}, {{"input_path", "p"}, {"input_path", "q"}}), ElementsAre("p", "q"));
  // The command line's replace those of the ini file.
  EXPECT_THAT(ParseList({"--input_path", "z"}, {{"input_path", "p"}, {"input_path", "q"}}),
              ElementsAre("z"));
}

TEST(CommandLine, HelpSaysOfListsThatTheyMayBeRepeated) {
  ListOptions options;
  OptionSet own, common;
  options.Describe(&own);
  CommandInfo info;
  info.name = "test";
  EXPECT_THAT(CommandHelp("lsmvs test", info, own, common, true),
              HasSubstr("Files. May be given several times."));
}

// The short help has every option without a group, and the groups by name only.
TEST(CommandLine, ShortHelpLeavesGroupsToHelpAll) {
  Options options;
  OptionSet own, common;
  options.Describe(&own);
  CommandInfo info;
  info.name = "test";
  const std::string text = CommandHelp("lsmvs test", info, own, common, false);
  EXPECT_THAT(text, HasSubstr("--max_image_size INT"));
  EXPECT_THAT(text, HasSubstr("--help_all"));
  EXPECT_THAT(text, HasSubstr("Group"));
  EXPECT_THAT(text, Not(HasSubstr("--Group.size")));
  EXPECT_THAT(CommandHelp("lsmvs test", info, own, common, true), HasSubstr("--Group.size"));
}

TEST(CommandLine, TakesValuesFlagsAndThePositional) {
  const Parsed parsed =
      Parse({"--overwrite", "folder", "--max_image_size", "-1", "--Group.max_error=0.25"});
  EXPECT_EQ(parsed.options.workspace, "folder");
  EXPECT_TRUE(parsed.options.overwrite);
  EXPECT_EQ(parsed.options.size, -1);
  EXPECT_EQ(parsed.options.error, 0.25);
}

TEST(CommandLine, FlagsTakeAnExplicitValueToo) {
  EXPECT_FALSE(Parse({"--overwrite", "0"}).options.overwrite);
  EXPECT_FALSE(Parse({"--overwrite=false"}).options.overwrite);
  EXPECT_TRUE(Parse({"--overwrite", "1", "w"}).options.overwrite);
}

TEST(CommandLine, TheLastOfARepeatedOptionWins) {
  EXPECT_EQ(Parse({"--max_image_size", "5", "--max_image_size", "6"}).options.size, 6);
}

TEST(CommandLine, PresetsComeBeforeGroupedOptions) {
  EXPECT_EQ(Parse({}).options.group_size, 7);
  EXPECT_EQ(Parse({"--Group.size", "3"}).options.group_size, 3);
}

TEST(CommandLine, HelpAndVersionNeedNothingElse) {
  EXPECT_TRUE(Parse({"-h"}).line.help);
  EXPECT_TRUE(Parse({"--help"}).line.help);
  EXPECT_TRUE(Parse({"--version"}).line.version);
}

TEST(CommandLine, UnknownOptionNamesTheNearest) {
  EXPECT_THAT(UsageMessage({"--max_img_size", "3"}), HasSubstr("did you mean --max_image_size?"));
  EXPECT_THAT(UsageMessage({"--group.maxerror=3"}), HasSubstr("did you mean --Group.max_error?"));
  EXPECT_THAT(UsageMessage({"--max_error", "3"}), HasSubstr("did you mean --Group.max_error?"));
  EXPECT_THAT(UsageMessage({"--zzzzzzzzz"}), HasSubstr("unknown option --zzzzzzzzz; see --help"));
}

TEST(CommandLine, RefusesWhatDoesNotFit) {
  EXPECT_THAT(UsageMessage({"a", "b"}), HasSubstr("unexpected argument 'b'"));
  EXPECT_THAT(UsageMessage({"--max_image_size", "many"}), HasSubstr("a whole number"));
  EXPECT_THAT(UsageMessage({"--max_image_size", "101"}), HasSubstr("[-1, 100]"));
  EXPECT_THAT(UsageMessage({"--max_image_size"}), HasSubstr("max_image_size"));
  EXPECT_THAT(UsageMessage({"--Group.max_error", "nan"}), HasSubstr("[0, 1]"));
}

std::vector<std::string> ApplyIni(const std::string& content, Options* options) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "x.ini") << content;
  OptionSet set;
  options->Describe(&set);
  return ApplyAssignments(ReadIniFile(folder.path() / "x.ini"), {{"max_image_size", "50"}}, set,
                          [] {});
}

TEST(CommandLine, OptionsWithoutMeaningAreTakenWithTheirValues) {
  Options options;
  OptionSet set;
  options.Describe(&set);
  const std::vector<std::string> without_meaning = {"Group.use_cache", "gpu_index"};
  const CommandLine line = ParseCommandLine({"--Group.use_cache", "1", "--gpu_index", "-1",
                                             "folder", "--Group.use_cache=0", "--overwrite"},
                                            set, "workspace_path", without_meaning);
  EXPECT_THAT(line.without_meaning, testing::ElementsAre("Group.use_cache", "gpu_index"));
  EXPECT_THAT(line.assignments, testing::ElementsAre(Assignment("workspace_path", "folder"),
                                                     Assignment("overwrite", "1")));
  std::vector<Assignment> ini = {{"Group.use_cache", "1"}, {"Group.size", "2"}};
  std::set<std::string> names;
  TakeOutMeaningless(without_meaning, &ini, &names);
  EXPECT_THAT(ini, testing::ElementsAre(Assignment("Group.size", "2")));
  EXPECT_THAT(names, testing::ElementsAre("Group.use_cache"));
}

TEST(IniFile, SetsOptionsBelowTheCommandLine) {
  Options options;
  const auto ignored = ApplyIni(
      "# comment\nmax_image_size=20\noverwrite = "
      "true\n[Group]\nmax_error=0.125\nsize=9\n[Other]\nfoo=1\n",
      &options);
  EXPECT_EQ(options.size, 50);
  EXPECT_TRUE(options.overwrite);
  EXPECT_EQ(options.error, 0.125);
  EXPECT_EQ(options.group_size, 9);
  EXPECT_THAT(ignored, testing::ElementsAre("Other"));
}

TEST(IniFile, UnknownKeyOfAKnownGroupIsAnError) {
  Options options;
  EXPECT_THROW(ApplyIni("[Group]\nmax_eror=0.1\n", &options), UsageError);
  EXPECT_THROW(ApplyIni("max_images=0.1\n", &options), UsageError);
  EXPECT_THROW(ReadIniFile("/nonexistent/x.ini"), InputError);
}

TEST(Bytes, ParsesUnits) {
  EXPECT_EQ(ParseBytes("m", "4GB"), 4000000000u);
  EXPECT_EQ(ParseBytes("m", "1.5 g"), 1500000000u);
  EXPECT_EQ(ParseBytes("m", "500MB"), 500000000u);
  EXPECT_EQ(ParseBytes("m", "1 TB"), 1000000000000u);
  EXPECT_EQ(ParseBytes("m", "2"), 2000000000u);
  EXPECT_EQ(ParseBytes("m", "1.5 GiB"), size_t{3} << 29);
  EXPECT_EQ(ParseBytes("m", "500MiB"), size_t{500} << 20);
  for (const char* bad :
       {"", "GB", "-1", "0", "4 parsecs", "4 Gb/s", "4 GBB", "4 B", "1e30", "nan"}) {
    EXPECT_THROW(ParseBytes("m", bad), UsageError) << bad;
  }
}

TEST(Format, TimesAndSizesReadWell) {
  EXPECT_EQ(FormatSeconds(0.2), "1 s");
  EXPECT_EQ(FormatSeconds(187), "3:07 min");
  EXPECT_EQ(FormatSeconds(7500), "2:05 h");
}

TEST(CommonOptions, DefaultsAreValidAndBoundsHold) {
  CommonOptions options;
  EXPECT_TRUE(options.Check(nullptr));
  options.num_threads = -2;
  EXPECT_FALSE(options.Check(nullptr));
  options.num_threads = 0;
  EXPECT_THROW(options.MakeRunContext(nullptr), UsageError);
  options.num_threads = 3;
  EXPECT_EQ(options.MakeRunContext(nullptr).num_threads(), 3);
}

TEST(HelpText, WrapsAndIndents) {
  EXPECT_EQ(Wrap("aa bb cc\ndd", 2, 7), "  aa bb\n  cc\n  dd\n");
  EXPECT_EQ(Wrap("long-word-that-does-not-fit", 1, 5), " long-word-that-does-not-fit\n");
}

// A command that does nothing but what the test tells it.
class FakeCommand : public Command {
 public:
  CommandInfo Info() const override {
    return {"fake",           "a command for tests", "Does nothing.",
            {"lsmvs fake w"}, {"workspace_path"},    "workspace_path"};
  }
  void Describe(OptionSet* set) override { options.Describe(set); }
  void Run(const CommandContext& context) override {
    num_threads = context.run.num_threads();
    if (run) run();
  }
  Options options;
  int num_threads = 0;
  std::function<void()> run;
};

TEST(Program, ReturnsTheCodeOfWhatIsThrown) {
  FakeCommand command;
  const auto code = [&](std::function<void()> run) {
    command.run = std::move(run);
    return RunCommand("lsmvs fake", &command, {"w", "--num_threads", "2"});
  };
  EXPECT_EQ(code({}), 0);
  EXPECT_EQ(command.num_threads, 2);
  EXPECT_EQ(code([] { throw InputError("f", "bad", "fix it"); }), 3);
  EXPECT_EQ(code([] { throw CancelledError(); }), 130);
  EXPECT_EQ(code([] { throw std::bad_alloc(); }), 5);
  EXPECT_EQ(code([] { throw std::logic_error("oops"); }), 1);
  FakeCommand fresh;
  EXPECT_EQ(RunCommand("lsmvs fake", &fresh, {}), 2);
  EXPECT_EQ(RunCommand("lsmvs fake", &command, {"--nope"}), 2);
  EXPECT_EQ(RunCommand("lsmvs fake", &command, {"--help"}), 0);
}

TEST(Program, TableFindsCommandsAndSuggests) {
  const std::vector<CommandFactory> table = {[] { return std::make_unique<FakeCommand>(); }};
  EXPECT_EQ(RunCommandTable(table, {"fake", "w"}), 0);
  EXPECT_EQ(RunCommandTable(table, {"fak"}), 2);
  EXPECT_EQ(RunCommandTable(table, {}), 2);
  EXPECT_EQ(RunCommandTable(table, {"help"}), 0);
  EXPECT_EQ(RunCommandTable(table, {"--version"}), 0);
}

}  // namespace
}  // namespace lsmvs
