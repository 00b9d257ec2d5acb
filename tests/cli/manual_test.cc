#include "lsmvs/program/manual.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

#include "lsmvs/cli/command_table.h"
#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

using testing::HasSubstr;

class ManualTest : public testing::Test {
 protected:
  const std::string& Text(const std::string& path) const {
    for (const ManualFile& file : files_) {
      if (file.path == path) return file.text;
    }
    throw std::runtime_error(path + " is missing");
  }

  // What a program prints; it gets the text as a file.
  std::string OutputOf(const std::string& command, const std::string& text) const {
    const TemporaryFolder folder;
    const std::string path = (folder.path() / "file").string();
    std::ofstream(path) << text;
    std::FILE* pipe = popen(("{ " + command + "; } 2>&1 < " + path).c_str(), "r");
    std::string output;
    for (int c = 0; (c = std::fgetc(pipe)) != EOF;) output += static_cast<char>(c);
    pclose(pipe);
    return output;
  }

  const std::vector<ManualFile> files_ = MakeManual(CommandTable(), MakeMesherCommand);
};

TEST_F(ManualTest, EveryCommandHasItsPage) {
  EXPECT_EQ(files_.size(), CommandTable().size() + 4);
  for (const CommandFactory& make : CommandTable()) {
    const CommandInfo info = make()->Info();
    const std::string& page = Text("man/man1/lsmvs-" + info.name + ".1");
    EXPECT_THAT(page, HasSubstr(".SH OPTIONS"));
    EXPECT_THAT(page, HasSubstr("\\-\\-num_threads"));
    EXPECT_THAT(page, HasSubstr("EXIT STATUS"));
    EXPECT_THAT(Text("man/man1/lsmvs.1"), HasSubstr(info.name));
  }
}

TEST_F(ManualTest, BashOffersCommandsAndTheirOptions) {
  const std::string& completion = Text("bash-completion/completions/lsmvs");
  const auto offers = [&](const std::string& words, int word) {
    return OutputOf("bash -c '. /dev/stdin; COMP_WORDS=(" + words +
                        "); COMP_CWORD=" + std::to_string(word) + "; _lsmvs; echo ${COMPREPLY[*]}'",
                    completion);
  };
  EXPECT_EQ(offers("lsmvs mesh_ref", 1), "mesh_refiner\n");
  EXPECT_EQ(offers("lsmvs mesh_refiner --MeshRefinement.opt", 2), "--MeshRefinement.optimizer\n");
  EXPECT_EQ(offers("/usr/bin/lsmvs-mesher --qual", 1), "--quality\n");
  EXPECT_EQ(offers("lsmvs mesh_refiner file", 2), "\n");  // bash' own completion of file names
}

}  // namespace
}  // namespace lsmvs
