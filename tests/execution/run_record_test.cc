#include "lsmvs/execution/run_record.h"

#include <gtest/gtest.h>

#include <fstream>

#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"
#include "text_tasks.h"

namespace lsmvs {
namespace {

RunRecord MakeRecord(const std::filesystem::path& root) {
  RunRecord record(root);
  record.program = "test 1";
  TaskRecord task;
  task.stage = "stereo";
  task.version = "3";
  task.options = "b.x=0.1\na.y=two words\n";
  task.inputs_hash = "0123";
  task.outputs = {"out/a", "out/b"};
  task.seconds = 1.5;
  task.cpu_seconds = 2.5;
  task.peak_bytes = uint64_t{5} << 30;
  task.num_threads = 2;
  task.finished = "2020-01-01T00:00:00Z";
  task.counts = {{"points", 12345678}};
  record.tasks["stereo/a"] = record.tasks["stereo/b"] = task;
  record.tasks["stereo/b"].options = "b.x=0.2\n";
  record.files.SetMade("out/a", "aa", {10, -5}, "stereo/a");
  record.publishing = {"stereo/c", task, {{{1, 2}, "cc", "stereo/c"}, {{3, 4}, "dd", "stereo/c"}}};
  return record;
}

TEST(RunRecord, RoundTrip) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "run.json";
  WriteRunRecord(path, MakeRecord(folder.path()));
  const RunRecord read = ReadRunRecord(path, folder.path());
  const RunRecord expected = MakeRecord(folder.path());
  EXPECT_EQ(read.program, expected.program);
  ASSERT_EQ(read.tasks.size(), 2u);
  for (const auto& [name, task] : expected.tasks) {
    const TaskRecord& other = read.tasks.at(name);
    EXPECT_EQ(other.stage, task.stage);
    EXPECT_EQ(other.version, task.version);
    EXPECT_EQ(other.options, task.options);
    EXPECT_EQ(other.inputs_hash, task.inputs_hash);
    EXPECT_EQ(other.outputs, task.outputs);
    EXPECT_EQ(other.seconds, task.seconds);
    EXPECT_EQ(other.peak_bytes, task.peak_bytes);
    EXPECT_EQ(other.counts, task.counts);
  }
  EXPECT_EQ(read.files.entries().at("out/a").made_by, "stereo/a");
  EXPECT_EQ(read.files.entries().at("out/a").stamp, (FileStamp{10, -5}));
  ASSERT_TRUE(read.publishing.has_value());
  EXPECT_EQ(read.publishing->name, "stereo/c");
  EXPECT_EQ(read.publishing->files.at(1).hash, "dd");
  WriteRunRecord(folder.path() / "again.json", read);
  EXPECT_EQ(ReadText(path), ReadText(folder.path() / "again.json"));
}

// The record is taken out of the text while it is parsed: names may be missing or nested otherwise.
TEST(RunRecord, JsonOfAnotherShapeIsRefused) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "run.json";
  for (const char* text :
       {"[]", "[{}]", "[[[[[{}]]]]]", "{}", R"({"format": 1})",
        R"({"stages": [{"tasks": {"a": {}}}]})", R"({"files": [{}]})",
        R"({"stages": {"a": [[[{}]]]}})", R"({"format": 1, "program": "p", "stages": {}})",
        R"({"format": 1, "program": "p", "stages": {"s": [{}]}, "files": {}})",
        R"({"format": 1, "program": "p", "stages": {"s": [{"tasks": {"a": {}}}]}, "files": {}})",
        R"({"format": 1, "program": "p", "files": {},
            "stages": {"s": [{"version": "1", "options": {}, "tasks": {"a": 1}}]}})",
        R"({"format": 1, "program": "p", "stages": {}, "files": {"a": {}}})",
        R"({"format": 2, "program": "p", "stages": {}, "files": {}})"}) {
    std::ofstream(path) << text;
    EXPECT_THROW(ReadRunRecord(path, folder.path()), InputError) << text;
  }
  std::ofstream(path) << R"({"format": 1, "program": "p", "stages": {}, "files": {}})";
  EXPECT_EQ(ReadRunRecord(path, folder.path()).program, "p");
}

TEST(RunRecord, AbsentIsEmptyAndGarbageIsRefusedWithItsName) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "run.json";
  EXPECT_TRUE(ReadRunRecord(path, folder.path()).tasks.empty());
  WriteRunRecord(path, MakeRecord(folder.path()));
  const std::string good = ReadText(path);
  for (size_t length = 0; length + 2 < good.size(); length += 7) {
    WriteText(path, good.substr(0, length));
    EXPECT_THROW(ReadRunRecord(path, folder.path()), InputError) << length;
  }
  WriteText(path, "{\"format\": 99}");
  EXPECT_THROW(ReadRunRecord(path, folder.path()), InputError);
}

TEST(FileTable, KnowsFilesByTheirRelativePath) {
  const TemporaryFolder folder;
  FileTable table(folder.path());
  EXPECT_EQ(table.Key(folder.path() / "a/../b"), "b");
  EXPECT_EQ(table.Key("/nowhere/b"), "/nowhere/b");
  EXPECT_EQ(table.PathOfKey("/nowhere/b"), "/nowhere/b");
}

TEST(FileTable, ForgetsThatAFileIsOursWhenItsBytesChange) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "f";
  WriteText(path, "one");
  FileTable table(folder.path());
  const std::string hash = table.Hash(path);
  table.SetMade("f", hash, StampOf(path), "task");
  EXPECT_EQ(table.MadeBy(path), "task");
  WriteText(path, "two");
  std::filesystem::last_write_time(
      path, std::filesystem::file_time_type::clock::now() + std::chrono::seconds(5));
  EXPECT_EQ(table.MadeBy(path), "");
  EXPECT_NE(table.Hash(path), hash);
}

}  // namespace
}  // namespace lsmvs
