#include "lsmvs/colmap_adapter/depth_map_io.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "lsmvs/colmap_adapter/files/binary_reader.h"
#include "lsmvs/colmap_adapter/files/compact_map.h"
#include "lsmvs/scene/depth_normals.h"
#include "lsmvs/scene/packed_depth_map.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/lru_cache.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

// From one ray to the other every sample is moved along its own tangent plane: with n the normal
// and a, b the two rays (z = 1), depth_b = depth_a * n.a / n.b. Reading undoes what writing does,
// up to the rounding of a float. A surface that the plane fits to second order keeps a bias of its
// sagitta over 0.7 pixels: 0.001 pixels for a sphere of 250 pixels' radius. Samples without normal,
// or seen at less than 5 degrees from their plane, keep their depth.

constexpr const char* kRemedy = "remove it to have it made again";
constexpr uint64_t kMaxMapSide = 1000000;
constexpr int kNormalChannels = 3;
// Cosine of the angle between normal and ray below which a tangent plane says nothing about the
// next pixel: sin(5 degrees).
constexpr double kMinCosine = 0.0872;

struct MapHeader {
  int width = 0, height = 0, channels = 0;

  uint64_t num_values() const {
    return static_cast<uint64_t>(width) * static_cast<uint64_t>(height) *
           static_cast<uint64_t>(channels);
  }
};

int ReadHeaderNumber(internal::BinaryReader* reader) {
  const uint64_t position = reader->Position();
  std::string digits;
  for (char c = reader->Read<char>(); c != '&'; c = reader->Read<char>()) {
    if (c < '0' || c > '9' || digits.size() == 7) {
      reader->FailAt("does not begin with 'width&height&channels&'", position);
    }
    digits.push_back(c);
  }
  uint64_t value = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (value < 1 || value > kMaxMapSide) {
    reader->FailAt(fmt::format("has the impossible size '{}'", digits), position);
  }
  return static_cast<int>(value);
}

// Reads the header and checks that the file is as long as it says.
MapHeader ReadHeader(int channels, internal::BinaryReader* reader) {
  MapHeader header;
  header.width = ReadHeaderNumber(reader);
  header.height = ReadHeaderNumber(reader);
  header.channels = ReadHeaderNumber(reader);
  if (header.channels != channels) {
    reader->Fail(fmt::format("has {} channels instead of {}", header.channels, channels));
  }
  const uint64_t num_bytes = header.num_values() * sizeof(float);
  if (reader->Remaining() != num_bytes) {
    reader->Fail(fmt::format("is cut off or damaged: {} bytes of values instead of {}",
                             reader->Remaining(), num_bytes));
  }
  return header;
}

Raster<float> ReadDepths(const fs::path& path) {
  if (internal::IsCompactMap(path)) return internal::ReadCompactDepths(path, kRemedy);
  internal::BinaryReader reader(path, kRemedy);
  const MapHeader header = ReadHeader(1, &reader);
  Raster<float> depths(header.width, header.height);
  reader.ReadBytes(depths.pixels.data(), depths.size() * sizeof(float));
  for (float& depth : depths.pixels) {
    if (!(depth > 0) || !std::isfinite(depth)) depth = 0;
  }
  return depths;
}

Eigen::Vector3f CleanNormal(const Eigen::Vector3f& normal) {
  const float norm = normal.norm();
  const bool is_valid = std::isfinite(norm) && norm > 0.5f && norm < 2.0f && normal.z() < 0;
  if (!is_valid) return Eigen::Vector3f::Zero();
  // What has unit length already keeps its bytes.
  return std::abs(norm - 1) < 1e-6f ? normal : Eigen::Vector3f(normal / norm);
}

Raster<Eigen::Vector3f> ReadNormals(const fs::path& path) {
  if (internal::IsCompactMap(path)) return internal::ReadCompactNormals(path, kRemedy);
  internal::BinaryReader reader(path, kRemedy);
  const MapHeader header = ReadHeader(kNormalChannels, &reader);
  Raster<Eigen::Vector3f> normals(header.width, header.height);
  std::vector<float> row(static_cast<size_t>(header.width));
  for (int channel = 0; channel < kNormalChannels; ++channel) {
    for (int y = 0; y < header.height; ++y) {
      reader.ReadBytes(row.data(), row.size() * sizeof(float));
      for (int x = 0; x < header.width; ++x) normals(x, y)[channel] = row[static_cast<size_t>(x)];
    }
  }
  for (Eigen::Vector3f& normal : normals.pixels) normal = CleanNormal(normal);
  return normals;
}

void CheckSize(const fs::path& path, int width, int height, const PinholeCamera& camera) {
  if (width <= camera.width && height <= camera.height) return;
  throw InputError(path.string(),
                   fmt::format("is {} x {}, larger than its image ({} x {})", width, height,
                               camera.width, camera.height),
                   "it belongs to another workspace; remove it");
}

std::string Header(int width, int height, int channels) {
  return fmt::format("{}&{}&{}&", width, height, channels);
}

void WriteDepths(const fs::path& path, const Raster<float>& depths) {
  AtomicFile file(path);
  file.Write(Header(depths.width, depths.height, 1));
  file.Write(depths.pixels.data(), depths.size() * sizeof(float));
  file.Commit();
}

void WriteNormals(const fs::path& path, const Raster<Eigen::Vector3f>& normals) {
  AtomicFile file(path);
  file.Write(Header(normals.width, normals.height, kNormalChannels));
  std::vector<float> plane(normals.size());
  for (int channel = 0; channel < kNormalChannels; ++channel) {
    for (size_t i = 0; i < plane.size(); ++i) plane[i] = normals.pixels[i][channel];
    file.Write(plane.data(), plane.size() * sizeof(float));
  }
  file.Commit();
}

// Depth where the ray `to` meets the tangent plane of the sample at `depth` on the ray `from`.
float DepthOnRay(float depth, const Eigen::Vector3f& normal_float, const Eigen::Vector3d& from,
                 const Eigen::Vector3d& to) {
  const Eigen::Vector3d normal = normal_float.cast<double>();
  const double dot_from = normal.dot(from), dot_to = normal.dot(to);
  // The same test in both directions, so that a sample is moved on reading if it was on writing.
  const bool is_steep = -dot_from < kMinCosine * from.norm() || -dot_to < kMinCosine * to.norm();
  return is_steep ? depth : static_cast<float>(depth * dot_from / dot_to);
}

void MoveSamples(const PinholeCamera& full_size_camera, double from_px, double to_px,
                 DepthMap* map) {
  const PinholeCamera camera = full_size_camera.Resized(map->depth.width, map->depth.height);
  for (int row = 0; row < map->depth.height; ++row) {
    for (int column = 0; column < map->depth.width; ++column) {
      float& depth = map->depth(column, row);
      if (!(depth > 0)) continue;
      const Eigen::Vector2d x_px(column, row);
      depth = DepthOnRay(depth, map->normal(column, row),
                         camera.Ray(x_px + Eigen::Vector2d::Constant(from_px)),
                         camera.Ray(x_px + Eigen::Vector2d::Constant(to_px)));
    }
  }
}

}  // namespace

void MoveSamplesToPixelCorners(const PinholeCamera& full_size_camera, DepthMap* map) {
  MoveSamples(full_size_camera, 0.5, 0.0, map);
}

void MoveSamplesToPixelCenters(const PinholeCamera& full_size_camera, DepthMap* map) {
  MoveSamples(full_size_camera, 0.0, 0.5, map);
}

std::optional<Eigen::Vector2i> CompleteMapSize(const fs::path& path, int channels) {
  if (!fs::is_regular_file(path)) return std::nullopt;
  if (internal::IsCompactMap(path)) {
    return internal::CompactMapSize(
        path, channels == 1 ? internal::MapKind::kDepth : internal::MapKind::kNormal);
  }
  try {
    internal::BinaryReader reader(path, kRemedy);
    const MapHeader header = ReadHeader(channels, &reader);
    return Eigen::Vector2i(header.width, header.height);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

bool HasDepthMap(const DenseWorkspace& workspace, const View& view, DepthMapKind type) {
  const auto depth_size = CompleteMapSize(workspace.DepthMapPath(view.name, type), 1);
  const fs::path normal_path = workspace.NormalMapPath(view.name, type);
  if (!fs::exists(normal_path)) return depth_size.has_value();
  const auto normal_size = CompleteMapSize(normal_path, kNormalChannels);
  return depth_size && normal_size && *depth_size == *normal_size;
}

DepthMap ReadDepthMap(const DenseWorkspace& workspace, const View& view, DepthMapKind type) {
  const fs::path depth_path = workspace.DepthMapPath(view.name, type);
  const fs::path normal_path = workspace.NormalMapPath(view.name, type);
  DepthMap map;
  map.depth = ReadDepths(depth_path);
  CheckSize(depth_path, map.depth.width, map.depth.height, view.camera);
  if (fs::exists(normal_path)) {
    map.normal = ReadNormals(normal_path);
    if (map.normal.width != map.depth.width || map.normal.height != map.depth.height) {
      throw InputError(normal_path.string(),
                       fmt::format("is {} x {}, but the depth map is {} x {}", map.normal.width,
                                   map.normal.height, map.depth.width, map.depth.height),
                       kRemedy);
    }
  } else {
    constexpr double kPixelCorner = 0;
    map.normal = NormalsFromDepth(map.depth, view.camera.Resized(map.depth.width, map.depth.height),
                                  kPixelCorner);
  }
  MoveSamplesToPixelCenters(view.camera, &map);
  return map;
}

void WriteDepthMap(const DenseWorkspace& workspace, const View& view, DepthMapKind type,
                   const DepthMap& map, MapFormat format) {
  LSMVS_CHECK_EQ(map.normal.width, map.depth.width);
  LSMVS_CHECK_EQ(map.normal.height, map.depth.height);
  DepthMap moved = map;
  if (format == MapFormat::kCompact) {
    // Samples are moved along the planes that reading will move them back along.
    for (Eigen::Vector3f& normal : moved.normal.pixels) normal = internal::RoundNormal(normal);
  }
  MoveSamplesToPixelCorners(view.camera, &moved);
  const fs::path depth_path = workspace.DepthMapPath(view.name, type);
  const fs::path normal_path = workspace.NormalMapPath(view.name, type);
  if (format == MapFormat::kCompact) {
    internal::WriteCompactNormals(normal_path, moved.normal);
    internal::WriteCompactDepths(depth_path, moved.depth);
  } else {
    WriteNormals(normal_path, moved.normal);
    WriteDepths(depth_path, moved.depth);
  }
}

bool ConvertDepthMap(const DenseWorkspace& from, const View& view, DepthMapKind type,
                     MapFormat format, const DenseWorkspace& to) {
  const fs::path source = from.DepthMapPath(view.name, type);
  if (!fs::exists(source)) return false;
  const bool is_compact = internal::IsCompactMap(source);
  if (is_compact == (format == MapFormat::kCompact) && from.folder == to.folder) return false;
  WriteDepthMap(to, view, type, ReadDepthMap(from, view, type), format);
  return true;
}

namespace {

class FileDepthMapSource : public DepthMapSource {
 public:
  FileDepthMapSource(DenseWorkspace workspace, const Scene& scene, DepthMapKind type,
                     size_t budget_bytes)
      : workspace_(std::move(workspace)), scene_(scene), type_(type), maps_(budget_bytes) {}

  std::shared_ptr<const DepthMap> Get(int view_idx) const override {
    const std::shared_ptr<const PackedDepthMap> map =
        maps_.Get(view_idx, [&] { return Load(scene_.views.at(static_cast<size_t>(view_idx))); });
    return map ? std::make_shared<const DepthMap>(Unpack(*map)) : nullptr;
  }

 private:
  using Maps = LruCache<int, PackedDepthMap>;

  Maps::Loaded Load(const View& view) const {
    if (!HasDepthMap(workspace_, view, type_)) return {};
    auto map = std::make_shared<const PackedDepthMap>(Pack(ReadDepthMap(workspace_, view, type_)));
    return {map, map->NumBytes()};
  }

  const DenseWorkspace workspace_;
  const Scene& scene_;
  const DepthMapKind type_;
  mutable Maps maps_;
};

}  // namespace

std::unique_ptr<DepthMapSource> MakeDepthMapSource(const DenseWorkspace& workspace,
                                                   const Scene& scene, DepthMapKind type,
                                                   size_t budget_bytes) {
  return std::make_unique<FileDepthMapSource>(workspace, scene, type, budget_bytes);
}

}  // namespace lsmvs
