#include "lsmvs/colmap_adapter/database.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include "lsmvs/adapter_test/corruption.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/test_support/test_data.h"

namespace lsmvs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

// COLMAP's tables as far as we read them, with the extra columns that the versions differ in.
constexpr const char* kTables3 =
    "CREATE TABLE images (image_id INTEGER PRIMARY KEY, name TEXT, camera_id INTEGER, prior_qw "
    "REAL);"
    "CREATE TABLE keypoints (image_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER, data BLOB);"
    "CREATE TABLE two_view_geometries (pair_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER,"
    " data BLOB, config INTEGER, F BLOB, E BLOB, H BLOB);";
constexpr const char* kTables4 =
    "CREATE TABLE rigs (rig_id INTEGER PRIMARY KEY);"
    "CREATE TABLE images (image_id INTEGER PRIMARY KEY, name TEXT, camera_id INTEGER);"
    "CREATE TABLE keypoints (image_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER, data BLOB);"
    "CREATE TABLE descriptors (image_id INTEGER PRIMARY KEY, type INTEGER);"
    "CREATE TABLE two_view_geometries (pair_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER,"
    " data BLOB, config INTEGER, F BLOB, E BLOB, H BLOB, qvec BLOB, tvec BLOB);";
// Floats 1.0, 2.0, 0.5, 0.0 and pairs (3, 4), (5, 6), little endian.
constexpr const char* kRows =
    "INSERT INTO images (image_id, name, camera_id) VALUES (7, 'b.jpg', 1), (2, 'a b.jpg', 1);"
    "INSERT INTO keypoints VALUES (2, 1, 4, x'0000803f000000400000003f00000000');"
    "INSERT INTO keypoints VALUES (7, 2, 2, x'0000803f000000400000003f00000000');"
    "INSERT INTO two_view_geometries (pair_id, rows, cols, data, config) VALUES"
    " (2147483647 * 2 + 7, 2, 2, x'03000000040000000500000006000000', 3);"
    "INSERT INTO two_view_geometries (pair_id, rows, cols, data, config) VALUES"
    " (2147483647 * 1 + 7, 0, 2, NULL, 1);";

class DatabaseTest : public testing::TestWithParam<const char*> {
 protected:
  void Execute(const std::string& sql) const {
    sqlite3* handle = nullptr;
    ASSERT_EQ(sqlite3_open(path_.c_str(), &handle), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(handle, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(handle);
    sqlite3_close(handle);
  }

  TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "my #1 database%20?.db";
};

TEST_P(DatabaseTest, ReadsImagesKeypointsAndMatches) {
  Execute(std::string(GetParam()) + kRows);
  const ColmapDatabase database(path_);
  const auto images = database.ReadImages();
  ASSERT_EQ(images.size(), 2u);
  EXPECT_EQ(images[0].image_id, ImageId{2});
  EXPECT_EQ(images[0].name, "a b.jpg");
  const auto scaled = database.ReadKeypoints(ImageId{2});
  ASSERT_EQ(scaled.size(), 1u);
  EXPECT_EQ(scaled[0].x, Eigen::Vector2f(1, 2));
  EXPECT_EQ(scaled[0].shape, Eigen::Matrix2f(0.5f * Eigen::Matrix2f::Identity()));
  const auto plain = database.ReadKeypoints(ImageId{7});
  ASSERT_EQ(plain.size(), 2u);
  EXPECT_EQ(plain[1].x, Eigen::Vector2f(0.5f, 0));
  EXPECT_TRUE(plain[1].shape.isIdentity());
  EXPECT_TRUE(database.ReadKeypoints(ImageId{99}).empty());
  const auto geometries = database.ReadTwoViewGeometries();
  ASSERT_EQ(geometries.size(), 1u);
  EXPECT_EQ(geometries[0].image_id1, ImageId{2});
  EXPECT_EQ(geometries[0].image_id2, ImageId{7});
  EXPECT_EQ(geometries[0].config, 3);
  EXPECT_THAT(geometries[0].inlier_matches, ElementsAre(Pair(3, 4), Pair(5, 6)));
}

TEST_P(DatabaseTest, ReadsAWriteAheadLog) {
  Execute(std::string("PRAGMA journal_mode=WAL;") + GetParam());
  // The connection stays open, so that the rows are in the log only.
  sqlite3* handle = nullptr;
  ASSERT_EQ(sqlite3_open(path_.c_str(), &handle), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(handle, kRows, nullptr, nullptr, nullptr), SQLITE_OK);
  EXPECT_EQ(ColmapDatabase(path_).ReadImages().size(), 2u);
  sqlite3_close(handle);
}

TEST_P(DatabaseTest, WritesNothing) {
  Execute(std::string("PRAGMA journal_mode=WAL;") + GetParam() + kRows);
  const std::string before = ReadWholeFile(path_);
  ColmapDatabase(path_).ReadTwoViewGeometries();
  EXPECT_EQ(ReadWholeFile(path_), before);
  const auto count = std::distance(std::filesystem::directory_iterator(folder_.path()), {});
  EXPECT_EQ(count, 1);
}

TEST_P(DatabaseTest, BlobsOfTheWrongSizeAreErrors) {
  Execute(std::string(GetParam()) + kRows);
  Execute("UPDATE keypoints SET rows = 2 WHERE image_id = 2");
  const auto keypoints_error = [&] {
    return InputErrorOf([&] { ColmapDatabase(path_).ReadKeypoints(ImageId{2}); });
  };
  EXPECT_THAT(keypoints_error(), HasSubstr("has 16 bytes where 2 x 4 values should be"));
  Execute("UPDATE keypoints SET rows = 4611686018427387904, cols = 4 WHERE image_id = 2");
  EXPECT_THAT(keypoints_error(), HasSubstr("has 16 bytes where"));
  Execute("UPDATE keypoints SET rows = 4, cols = 1 WHERE image_id = 2");
  EXPECT_THAT(keypoints_error(), HasSubstr("keypoints of 1 numbers"));
  Execute("UPDATE keypoints SET rows = -1, cols = -4 WHERE image_id = 2");
  EXPECT_THAT(keypoints_error(), HasSubstr("has 16 bytes where -1 x -4"));
  Execute("UPDATE two_view_geometries SET data = x'00'");
  EXPECT_THAT(InputErrorOf([&] { ColmapDatabase(path_).ReadTwoViewGeometries(); }),
              HasSubstr("has 1 bytes where"));
}

TEST_P(DatabaseTest, MutationsNeverCrash) {
  Execute(std::string("PRAGMA page_size=512;") + GetParam() + kRows);
  ExpectSurvivesMutations(path_, 300, [&] {
    const ColmapDatabase database(path_);
    for (const auto& image : database.ReadImages()) database.ReadKeypoints(image.image_id);
    database.ReadTwoViewGeometries();
  });
}

INSTANTIATE_TEST_SUITE_P(Schemas, DatabaseTest, testing::Values(kTables3, kTables4));

TEST(DatabaseErrorTest, WhatIsNoDatabaseIsNamed) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "database.db";
  EXPECT_THAT(InputErrorOf([&] { ColmapDatabase database(path); }), HasSubstr("is missing"));
  WriteWholeFile(path, "this is not a database, and long enough to look like one");
  EXPECT_THAT(InputErrorOf([&] { ColmapDatabase database(path); }), HasSubstr("not a database"));
  WriteWholeFile(path, "");
  EXPECT_THAT(InputErrorOf([&] { ColmapDatabase database(path); }), HasSubstr("no such table"));
}

TEST(DatabaseRealTest, ReadsRealMatches) {
  LSMVS_REQUIRE_SCENE("fountain-P11");
  const ColmapDatabase database(TestDataFolder() / "fountain-P11" / "database.db");
  EXPECT_EQ(database.ReadImages().size(), 11u);
  for (const auto& image : database.ReadImages()) {
    const auto keypoints = database.ReadKeypoints(image.image_id);
    EXPECT_GT(keypoints.size(), 1000u);
    for (const auto& keypoint : keypoints) EXPECT_GE(keypoint.x.minCoeff(), 0);
  }
  EXPECT_GT(database.ReadTwoViewGeometries().size(), 20u);
}

}  // namespace
}  // namespace lsmvs
