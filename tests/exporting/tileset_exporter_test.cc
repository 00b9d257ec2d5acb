#include "lsmvs/exporting/tileset_exporter.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "lsmvs/exporting_test/textured_blob.h"
#include "lsmvs/synthetic/textured_atlas.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string Content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// The positions of a tile in the tileset's frame.
std::vector<Eigen::Vector3d> Positions(const fs::path& path) {
  const std::string bytes = Content(path);
  uint32_t json_size = 0;
  std::memcpy(&json_size, bytes.data() + 12, 4);
  const Json json = Json::parse(bytes.substr(20, json_size));
  const Json& node = json["nodes"][0];
  const auto r = node["rotation"].get<std::vector<double>>();
  const auto t = node["translation"].get<std::vector<double>>();
  const Eigen::Quaterniond rotation(r[3], r[0], r[1], r[2]);
  const Json& accessor =
      json["accessors"][json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].get<size_t>()];
  const Json& view = json["bufferViews"][accessor["bufferView"].get<size_t>()];
  std::vector<Eigen::Vector3d> positions;
  for (size_t i = 0; i < accessor["count"].get<size_t>(); ++i) {
    float x[3];
    std::memcpy(x, bytes.data() + 28 + json_size + view["byteOffset"].get<size_t>() + 12 * i, 12);
    const Eigen::Vector3d y_up =
        rotation * Eigen::Vector3d(x[0], x[1], x[2]) + Eigen::Vector3d(t[0], t[1], t[2]);
    positions.emplace_back(y_up.x(), -y_up.z(), y_up.y());  // as viewers turn it
  }
  return positions;
}

Eigen::AlignedBox3d Box(const Json& tile) {
  const auto b = tile["boundingVolume"]["box"].get<std::vector<double>>();
  const Eigen::Vector3d center(b[0], b[1], b[2]), half(b[3], b[7], b[11]);
  return {center - half, center + half};
}

class TilesetExporterTest : public ::testing::Test {
 protected:
  TilesetExporterTest() {
    AtlasOptions atlas;
    atlas.page_width = atlas.page_height = 1024;
    atlas.chart_px = 6;
    textured_ = PaintAtlas(BlobMesh(0.2), BlobColor, folder_.path(), atlas);
    options_.max_tile_faces = 150;
  }
  Json Export(const std::string& name, int num_threads,
              const std::optional<GeodeticPosition>& origin = std::nullopt) {
    const RunContext context(num_threads);
    summary_ = ExportTileset(Folder(name), textured_, {}, origin, {}, options_, context);
    return Json::parse(Content(Folder(name) / "tileset.json"));
  }
  fs::path Folder(const std::string& name) const { return folder_.path() / name; }

  TemporaryFolder folder_;
  TexturedMesh textured_;
  TilesetOptions options_;
  TilesetSummary summary_;
};

void VisitTiles(const Json& tile, const std::function<void(const Json&)>& visit) {
  visit(tile);
  if (!tile.contains("children")) return;
  for (const Json& child : tile["children"]) VisitTiles(child, visit);
}

TEST_F(TilesetExporterTest, TreeIsWhatTheFormatAsksFor) {
  const Json tileset = Export("tiles", 2);
  EXPECT_EQ(tileset["asset"]["version"], "1.1");
  EXPECT_GE(summary_.num_levels, 3);
  size_t count = 0;
  VisitTiles(tileset["root"], [&](const Json& tile) {
    ++count;
    EXPECT_EQ(tile["refine"], "REPLACE");
    const fs::path path = Folder("tiles") / tile["content"]["uri"].get<std::string>();
    ASSERT_TRUE(fs::exists(path));
    for (const Eigen::Vector3d& x : Positions(path)) EXPECT_TRUE(Box(tile).contains(x));
    EXPECT_EQ(tile["geometricError"].get<double>() == 0, !tile.contains("children"));
    if (!tile.contains("children")) return;
    for (const Json& child : tile["children"]) {
      EXPECT_TRUE(Box(tile).contains(Box(child)));
      EXPECT_GT(tile["geometricError"].get<double>(), child["geometricError"].get<double>());
    }
  });
  EXPECT_EQ(count, summary_.num_tiles);
  EXPECT_GT(tileset["geometricError"].get<double>(),
            tileset["root"]["geometricError"].get<double>());
}

// The vertices of all leaves are those of the mesh, z up.
TEST_F(TilesetExporterTest, LeavesHoldTheMesh) {
  const Json tileset = Export("tiles", 2);
  const auto t = tileset["root"]["transform"].get<std::vector<double>>();
  const Eigen::Matrix4d transform = Eigen::Map<const Eigen::Matrix4d>(t.data());
  std::vector<uint8_t> found(textured_.mesh.vertices.size(), 0);
  const auto key = [](const Eigen::Vector3d& x) {
    const Eigen::Vector3i cell = (x * 1e3).array().round().matrix().cast<int>();
    return std::tuple(cell.x(), cell.y(), cell.z());
  };
  std::map<std::tuple<int, int, int>, size_t> vertex_at;
  for (size_t v = 0; v < found.size(); ++v) {
    const Eigen::Vector3d& x = textured_.mesh.vertices[v];
    vertex_at[key({x.x(), x.z(), -x.y()})] = v;
  }
  VisitTiles(tileset["root"], [&](const Json& tile) {
    if (tile.contains("children")) return;
    const fs::path path = Folder("tiles") / tile["content"]["uri"].get<std::string>();
    for (const Eigen::Vector3d& x : Positions(path)) {
      const auto at = vertex_at.find(
          key(transform.topLeftCorner<3, 3>() * x + transform.topRightCorner<3, 1>()));
      if (at != vertex_at.end()) found[at->second] = 1;
    }
  });
  EXPECT_GT(std::count(found.begin(), found.end(), 1),
            static_cast<long>(0.97 * static_cast<double>(found.size())));  // rounding of keys
}

TEST_F(TilesetExporterTest, OriginPlacesItOnTheEarth) {
  const Json tileset = Export("tiles", 2, GeodeticPosition{48.2, 16.37, 171});
  const auto t = tileset["root"]["transform"].get<std::vector<double>>();
  const Eigen::Matrix4d transform = Eigen::Map<const Eigen::Matrix4d>(t.data());
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& x : textured_.mesh.vertices) box.extend(x);
  Eigen::Vector4d center;
  center << box.center(), 1;
  const Eigen::Vector4d expected = EcefFromEnu({48.2, 16.37, 171}) * center;
  EXPECT_LT((transform.col(3) - expected).norm(), 1e-6);
}

TEST_F(TilesetExporterTest, SameBytesForAnyNumberOfThreads) {
  Export("one", 1);
  Export("two", 2);
  std::set<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(Folder("one"))) {
    if (entry.is_regular_file()) files.insert(fs::relative(entry.path(), Folder("one")));
  }
  EXPECT_EQ(files.size(), summary_.num_tiles + 1);
  for (const fs::path& file : files) {
    EXPECT_TRUE(Content(Folder("one") / file) == Content(Folder("two") / file)) << file;
  }
}

TEST_F(TilesetExporterTest, OldTilesGo) {
  Export("tiles", 2);
  options_.max_tile_faces = 1 << 20;
  options_.max_tile_megatexels = 64;
  const Json tileset = Export("tiles", 2);
  EXPECT_FALSE(tileset["root"].contains("children"));
  EXPECT_EQ(std::distance(fs::directory_iterator(Folder("tiles") / "tiles"), {}), 1);
}

TEST(TilesetOptions, Bounds) {
  TilesetOptions options;
  std::string error;
  EXPECT_TRUE(options.Check(&error)) << error;
  options.max_tile_faces = 10;
  EXPECT_FALSE(options.Check(&error));
  options = {};
  options.max_tile_megatexels = 0;
  EXPECT_FALSE(options.Check(&error));
  options = {};
  options.texels_of_error = -1;
  EXPECT_FALSE(options.Check(&error));
}

}  // namespace
}  // namespace lsmvs
