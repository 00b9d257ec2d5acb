#include "lsmvs/colmap_adapter/files/compact_map.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>
#include <vector>

#include "lsmvs/colmap_adapter/files/binary_reader.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"

namespace lsmvs::internal {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "lsmvs-map ";
constexpr size_t kHeaderBytes = 96;
constexpr uint64_t kMaxSide = 1000000;
constexpr int kZstdLevel = 6;
constexpr double kMaxDepthCode = 65535, kNumDepthSteps = 65534;
constexpr float kHalfNormalSteps = 127;
constexpr size_t kBytesPerPixel = 2;

struct Header {
  std::string kind;
  uint64_t width = 0, height = 0, num_bytes = 0;
  double smallest = 0, largest = 0;

  size_t num_pixels() const { return static_cast<size_t>(width * height); }
};

std::string NameOf(MapKind kind) { return kind == MapKind::kDepth ? "depth" : "normal"; }

Header ReadHeader(MapKind kind, BinaryReader* reader) {
  std::string text(kHeaderBytes, '\0');
  reader->ReadBytes(text.data(), text.size());
  Header header;
  std::istringstream words(text);
  std::string magic;
  words >> magic >> header.kind >> header.width >> header.height >> header.smallest >>
      header.largest >> header.num_bytes;
  const bool is_sound = words && header.kind == NameOf(kind) && header.width >= 1 &&
                        header.height >= 1 && header.width <= kMaxSide &&
                        header.height <= kMaxSide && header.smallest >= 0 &&
                        header.largest >= header.smallest && std::isfinite(header.largest);
  if (!is_sound) reader->FailAt("is no compact map of this kind", 0);
  if (reader->Remaining() != header.num_bytes) {
    reader->Fail(fmt::format("is cut off or damaged: {} bytes of values instead of {}",
                             reader->Remaining(), header.num_bytes));
  }
  return header;
}

// The two planes of a map.
std::vector<uint8_t> ReadPlanes(const Header& header, BinaryReader* reader) {
  std::vector<char> packed(static_cast<size_t>(header.num_bytes));
  reader->ReadBytes(packed.data(), packed.size());
  const size_t num_bytes = kBytesPerPixel * header.num_pixels();
  // What a frame says of itself is asked before memory is taken.
  if (ZSTD_getFrameContentSize(packed.data(), packed.size()) != num_bytes) {
    reader->Fail("is damaged: its values have another size than it says");
  }
  std::vector<uint8_t> planes(num_bytes);
  const size_t size = ZSTD_decompress(planes.data(), planes.size(), packed.data(), packed.size());
  if (ZSTD_isError(size) != 0 || size != num_bytes) reader->Fail("is damaged: cannot be unpacked");
  return planes;
}

void WritePlanes(const fs::path& path, Header header, const std::vector<uint8_t>& planes) {
  std::vector<char> packed(ZSTD_compressBound(planes.size()));
  const size_t size =
      ZSTD_compress(packed.data(), packed.size(), planes.data(), planes.size(), kZstdLevel);
  if (ZSTD_isError(size) != 0) throw MemoryError(path.string() + ": cannot be packed");
  header.num_bytes = size;
  std::string text = fmt::format("{}{} {} {} {:.9g} {:.9g} {}", kMagic, header.kind, header.width,
                                 header.height, header.smallest, header.largest, header.num_bytes);
  text.resize(kHeaderBytes - 1, ' ');
  AtomicFile file(path);
  file.Write(text + "\n");
  file.Write(packed.data(), size);
  file.Commit();
}

// Smallest and largest depth, as the header's text says them.
std::array<double, 2> RangeOf(const Raster<float>& depths) {
  double smallest = std::numeric_limits<double>::infinity(), largest = 0;
  for (const float depth : depths.pixels) {
    if (!(depth > 0) || !std::isfinite(depth)) continue;
    smallest = std::min<double>(smallest, depth);
    largest = std::max<double>(largest, depth);
  }
  if (largest == 0) return {0, 0};
  return {smallest, largest};
}

std::array<uint8_t, 2> NormalCode(const Eigen::Vector3f& normal) {
  const float sum = normal.cwiseAbs().sum();
  if (!(sum > 0) || !(normal.z() < 0)) return {0, 0};
  const float x = normal.x() / sum, y = normal.y() / sum;
  const auto code = [](float value) {
    return static_cast<uint8_t>(1 + std::lround(kHalfNormalSteps * (1 + value)));
  };
  return {code(x + y), code(x - y)};
}

Eigen::Vector3f NormalOf(uint8_t u_code, uint8_t v_code) {
  if (u_code == 0 || v_code == 0) return Eigen::Vector3f::Zero();
  const float u = static_cast<float>(u_code - 1) / kHalfNormalSteps - 1;
  const float v = static_cast<float>(v_code - 1) / kHalfNormalSteps - 1;
  const float x = (u + v) / 2, y = (u - v) / 2;
  // On the rim z would be 0: towards the camera all the same.
  constexpr float kLeastZ = 1e-4f;
  return Eigen::Vector3f(x, y, -std::max(kLeastZ, 1 - std::abs(x) - std::abs(y))).normalized();
}

}  // namespace

bool IsCompactMap(const fs::path& path) {
  try {
    BinaryReader reader(path, "");
    if (reader.size() < kMagic.size()) return false;
    std::string magic(kMagic.size(), '\0');
    reader.ReadBytes(magic.data(), magic.size());
    return magic == kMagic;
  } catch (const InputError&) {
    return false;
  }
}

std::optional<Eigen::Vector2i> CompactMapSize(const fs::path& path, MapKind kind) {
  try {
    BinaryReader reader(path, "");
    const Header header = ReadHeader(kind, &reader);
    return Eigen::Vector2i(static_cast<int>(header.width), static_cast<int>(header.height));
  } catch (const InputError&) {
    return std::nullopt;
  }
}

Raster<float> ReadCompactDepths(const fs::path& path, const std::string& remedy) {
  BinaryReader reader(path, remedy);
  const Header header = ReadHeader(MapKind::kDepth, &reader);
  const std::vector<uint8_t> planes = ReadPlanes(header, &reader);
  Raster<float> depths(static_cast<int>(header.width), static_cast<int>(header.height));
  // One depth a code: a table is faster than that many exponentials.
  std::vector<float> depth_of(static_cast<size_t>(kMaxDepthCode) + 1, 0.0f);
  const double step =
      header.smallest > 0 ? std::log(header.largest / header.smallest) / kNumDepthSteps : 0.0;
  for (size_t code = 1; code < depth_of.size(); ++code) {
    depth_of[code] =
        static_cast<float>(header.smallest * std::exp(step * static_cast<double>(code - 1)));
  }
  const size_t num_pixels = header.num_pixels();
  uint16_t code = 0;
  for (size_t i = 0; i < num_pixels; ++i) {
    if (i % header.width == 0) code = 0;
    code = static_cast<uint16_t>(code + planes[i] + (planes[num_pixels + i] << 8));
    depths.pixels[i] = depth_of[code];
  }
  return depths;
}

Raster<Eigen::Vector3f> ReadCompactNormals(const fs::path& path, const std::string& remedy) {
  BinaryReader reader(path, remedy);
  const Header header = ReadHeader(MapKind::kNormal, &reader);
  const std::vector<uint8_t> planes = ReadPlanes(header, &reader);
  Raster<Eigen::Vector3f> normals(static_cast<int>(header.width), static_cast<int>(header.height));
  const size_t num_pixels = header.num_pixels();
  uint8_t u = 0, v = 0;
  for (size_t i = 0; i < num_pixels; ++i) {
    if (i % header.width == 0) u = v = 0;
    u = static_cast<uint8_t>(u + planes[i]);
    v = static_cast<uint8_t>(v + planes[num_pixels + i]);
    normals.pixels[i] = NormalOf(u, v);
  }
  return normals;
}

void WriteCompactDepths(const fs::path& path, const Raster<float>& depths) {
  const auto [smallest, largest] = RangeOf(depths);
  const double range = largest > smallest ? std::log(largest / smallest) : 1.0;
  const size_t num_pixels = depths.size();
  std::vector<uint8_t> planes(kBytesPerPixel * num_pixels);
  uint16_t left = 0;
  for (size_t i = 0; i < num_pixels; ++i) {
    if (i % static_cast<size_t>(depths.width) == 0) left = 0;
    const float depth = depths.pixels[i];
    uint16_t code = 0;
    if (depth > 0 && std::isfinite(depth)) {
      code = static_cast<uint16_t>(
          1 + std::lround(kNumDepthSteps * std::log(depth / smallest) / range));
    }
    const auto delta = static_cast<uint16_t>(code - left);
    planes[i] = static_cast<uint8_t>(delta & 0xff);
    planes[num_pixels + i] = static_cast<uint8_t>(delta >> 8);
    left = code;
  }
  WritePlanes(path,
              {NameOf(MapKind::kDepth), static_cast<uint64_t>(depths.width),
               static_cast<uint64_t>(depths.height), 0, smallest, largest},
              planes);
}

void WriteCompactNormals(const fs::path& path, const Raster<Eigen::Vector3f>& normals) {
  const size_t num_pixels = normals.size();
  std::vector<uint8_t> planes(kBytesPerPixel * num_pixels);
  std::array<uint8_t, 2> left = {0, 0};
  for (size_t i = 0; i < num_pixels; ++i) {
    if (i % static_cast<size_t>(normals.width) == 0) left = {0, 0};
    const std::array<uint8_t, 2> code = NormalCode(normals.pixels[i]);
    planes[i] = static_cast<uint8_t>(code[0] - left[0]);
    planes[num_pixels + i] = static_cast<uint8_t>(code[1] - left[1]);
    left = code;
  }
  WritePlanes(path,
              {NameOf(MapKind::kNormal), static_cast<uint64_t>(normals.width),
               static_cast<uint64_t>(normals.height), 0, 0, 0},
              planes);
}

Eigen::Vector3f RoundNormal(const Eigen::Vector3f& normal) {
  const std::array<uint8_t, 2> code = NormalCode(normal);
  return NormalOf(code[0], code[1]);
}

}  // namespace lsmvs::internal
