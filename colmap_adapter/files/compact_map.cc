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
constexpr int kFormat = 2;
constexpr size_t kHeaderBytes = 96;
constexpr uint64_t kMaxSide = 1000000;
constexpr int kZstdLevel = 6;
constexpr int kMaxDepthCode = 65535, kNumDepthSteps = 65534;
// A step of depth, as what it moves a point before a camera whose focal length is the longer side
// of the map, in pixels of the surface: no method is as good as half of that.
constexpr double kStepPx = 0.05;
constexpr int kHalfNormalSteps = 255;
constexpr int kNumNormalCodes = 2 * kHalfNormalSteps + 1;

struct Header {
  std::string kind;
  uint64_t width = 0, height = 0, num_bytes = 0;
  double smallest = 0, step = 0;  // of depths, in their logarithm

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
      header.step >> header.num_bytes;
  const bool has_sizes = !words.fail();
  int format = 1;  // the first format has no number
  if (has_sizes && !(words >> format)) format = 1;
  const bool is_sound = has_sizes && header.kind == NameOf(kind) && header.width >= 1 &&
                        header.height >= 1 && header.width <= kMaxSide &&
                        header.height <= kMaxSide && header.smallest >= 0 && header.step >= 0 &&
                        std::isfinite(header.smallest * std::exp(header.step * kNumDepthSteps));
  if (!is_sound) reader->FailAt("is no compact map of this kind", 0);
  if (format != kFormat) {
    reader->FailAt(fmt::format("is a compact map of format {}, not {}", format, kFormat), 0);
  }
  if (reader->Remaining() != header.num_bytes) {
    reader->Fail(fmt::format("is cut off or damaged: {} bytes of values instead of {}",
                             reader->Remaining(), header.num_bytes));
  }
  return header;
}

// Bytes of a map in work: one bit per pixel that has a value, then for each of `num_channels` the
// lower bytes of all pixels and the upper ones.
size_t MaskBytes(size_t num_pixels) { return (num_pixels + 7) / 8; }
size_t PlaneBytes(size_t num_pixels, int num_channels) {
  return MaskBytes(num_pixels) + 2 * num_pixels * static_cast<size_t>(num_channels);
}

std::vector<uint8_t> ReadPlanes(const Header& header, int num_channels, BinaryReader* reader) {
  std::vector<char> packed(static_cast<size_t>(header.num_bytes));
  reader->ReadBytes(packed.data(), packed.size());
  const size_t num_bytes = PlaneBytes(header.num_pixels(), num_channels);
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
  std::string text =
      fmt::format("{}{} {} {} {:.9g} {:.9g} {} {}", kMagic, header.kind, header.width,
                  header.height, header.smallest, header.step, header.num_bytes, kFormat);
  text.resize(kHeaderBytes - 1, ' ');
  AtomicFile file(path);
  file.Write(text + "\n");
  file.Write(packed.data(), size);
  file.Commit();
}

// Codes of a channel, each from 1 to `num_codes`, 0 where there is no value. In the file is how far
// each is from what its neighbours to the left and above foretell, modulo the number of codes.
class Channel {
 public:
  Channel(int width, int height, int num_codes)
      : width_(static_cast<size_t>(width)),
        num_pixels_(width_ * static_cast<size_t>(height)),
        num_codes_(num_codes),
        codes_(num_pixels_, 0) {}

  std::vector<int32_t>& codes() { return codes_; }

  // Writes the channel's planes, of `index`; the mask is written by the first.
  void Pack(int index, std::vector<uint8_t>* planes) const {
    uint8_t* low = PlaneOf(index, planes->data());
    uint8_t* high = low + num_pixels_;
    for (size_t i = 0; i < num_pixels_; ++i) {
      if (codes_[i] == 0) continue;
      if (index == 0) (*planes)[i / 8] |= static_cast<uint8_t>(1u << i % 8);
      const uint32_t code = Folded(codes_[i] - Foretold(i));
      low[i] = static_cast<uint8_t>(code & 0xff);
      high[i] = static_cast<uint8_t>(code >> 8);
    }
  }

  // False if the planes are not what Pack makes.
  bool Unpack(int index, std::vector<uint8_t>* planes) {
    const uint8_t* low = PlaneOf(index, planes->data());
    const uint8_t* high = low + num_pixels_;
    for (size_t i = 0; i < num_pixels_; ++i) {
      if (((*planes)[i / 8] >> i % 8 & 1) == 0) continue;
      const int32_t code = Foretold(i) + Unfolded(low[i] | static_cast<uint32_t>(high[i]) << 8);
      codes_[i] = 1 + Modulo(code - 1);
      if (code < 1 - num_codes_ || code > 2 * num_codes_) return false;
    }
    return true;
  }

 private:
  uint8_t* PlaneOf(int index, uint8_t* planes) const {
    return planes + MaskBytes(num_pixels_) + 2 * num_pixels_ * static_cast<size_t>(index);
  }
  int32_t Modulo(int32_t value) const {
    value %= num_codes_;
    return value < 0 ? value + num_codes_ : value;
  }
  // 0, -1, 1, -2, 2, ... as 0, 1, 2, 3, 4, ..., the nearer way round.
  uint32_t Folded(int32_t difference) const {
    int32_t folded = Modulo(difference);
    if (folded > num_codes_ / 2) folded -= num_codes_;
    return folded < 0 ? static_cast<uint32_t>(-2 * folded - 1) : static_cast<uint32_t>(2 * folded);
  }
  static int32_t Unfolded(uint32_t code) {
    const auto half = static_cast<int32_t>(code / 2);
    return code % 2 == 1 ? -half - 1 : half;
  }

  // The plane through the three neighbours, within the two that touch the pixel; else what is
  // there.
  int32_t Foretold(size_t i) const {
    const int32_t left = i % width_ > 0 ? codes_[i - 1] : 0;
    const int32_t above = i >= width_ ? codes_[i - width_] : 0;
    if (left == 0 || above == 0) return left != 0 ? left : above;
    const int32_t corner = i % width_ > 0 && i >= width_ ? codes_[i - width_ - 1] : 0;
    if (corner == 0) return left;
    return std::clamp(left + above - corner, std::min(left, above), std::max(left, above));
  }

  const size_t width_, num_pixels_;
  const int32_t num_codes_;
  std::vector<int32_t> codes_;
};

// Smallest and largest depth.
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

// Of both coordinates of the octahedron's map, from 1; zeros for no normal.
std::array<int32_t, 2> NormalCode(const Eigen::Vector3f& normal) {
  const float sum = normal.cwiseAbs().sum();
  if (!(sum > 0) || !(normal.z() < 0)) return {0, 0};
  const float x = normal.x() / sum, y = normal.y() / sum;
  const auto code = [](float value) {
    return static_cast<int32_t>(1 + std::lround(kHalfNormalSteps * (1 + value)));
  };
  return {code(x + y), code(x - y)};
}

Eigen::Vector3f NormalOf(int32_t u_code, int32_t v_code) {
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
  std::vector<uint8_t> planes = ReadPlanes(header, 1, &reader);
  Raster<float> depths(static_cast<int>(header.width), static_cast<int>(header.height));
  Channel channel(depths.width, depths.height, kMaxDepthCode);
  if (!channel.Unpack(0, &planes)) reader.Fail("is damaged: has depths that are none");
  // One depth a code: a table is faster than that many exponentials.
  std::vector<float> depth_of(static_cast<size_t>(kMaxDepthCode) + 1, 0.0f);
  for (size_t code = 1; code < depth_of.size(); ++code) {
    depth_of[code] =
        static_cast<float>(header.smallest * std::exp(header.step * static_cast<double>(code - 1)));
  }
  for (size_t i = 0; i < depths.size(); ++i) {
    depths.pixels[i] = depth_of[static_cast<size_t>(channel.codes()[i])];
  }
  return depths;
}

Raster<Eigen::Vector3f> ReadCompactNormals(const fs::path& path, const std::string& remedy) {
  BinaryReader reader(path, remedy);
  const Header header = ReadHeader(MapKind::kNormal, &reader);
  std::vector<uint8_t> planes = ReadPlanes(header, 2, &reader);
  Raster<Eigen::Vector3f> normals(static_cast<int>(header.width), static_cast<int>(header.height));
  Channel u(normals.width, normals.height, kNumNormalCodes),
      v(normals.width, normals.height, kNumNormalCodes);
  if (!u.Unpack(0, &planes) || !v.Unpack(1, &planes)) {
    reader.Fail("is damaged: has normals that are none");
  }
  for (size_t i = 0; i < normals.size(); ++i) {
    normals.pixels[i] = NormalOf(u.codes()[i], v.codes()[i]);
  }
  return normals;
}

void WriteCompactDepths(const fs::path& path, const Raster<float>& depths) {
  const auto [smallest, largest] = RangeOf(depths);
  const double range = largest > smallest ? std::log(largest / smallest) : 0.0;
  const double step =
      std::max(range / kNumDepthSteps, kStepPx / std::max(depths.width, depths.height));
  Channel channel(depths.width, depths.height, kMaxDepthCode);
  for (size_t i = 0; i < depths.size(); ++i) {
    const float depth = depths.pixels[i];
    if (!(depth > 0) || !std::isfinite(depth)) continue;
    const auto code = static_cast<int32_t>(1 + std::lround(std::log(depth / smallest) / step));
    channel.codes()[i] = std::min(code, kMaxDepthCode);
  }
  std::vector<uint8_t> planes(PlaneBytes(depths.size(), 1), 0);
  channel.Pack(0, &planes);
  WritePlanes(path,
              {NameOf(MapKind::kDepth), static_cast<uint64_t>(depths.width),
               static_cast<uint64_t>(depths.height), 0, smallest, step},
              planes);
}

void WriteCompactNormals(const fs::path& path, const Raster<Eigen::Vector3f>& normals) {
  Channel u(normals.width, normals.height, kNumNormalCodes),
      v(normals.width, normals.height, kNumNormalCodes);
  for (size_t i = 0; i < normals.size(); ++i) {
    const std::array<int32_t, 2> code = NormalCode(normals.pixels[i]);
    u.codes()[i] = code[0];
    v.codes()[i] = code[1];
  }
  std::vector<uint8_t> planes(PlaneBytes(normals.size(), 2), 0);
  u.Pack(0, &planes);
  v.Pack(1, &planes);
  WritePlanes(path,
              {NameOf(MapKind::kNormal), static_cast<uint64_t>(normals.width),
               static_cast<uint64_t>(normals.height), 0, 0, 0},
              planes);
}

Eigen::Vector3f RoundNormal(const Eigen::Vector3f& normal) {
  const std::array<int32_t, 2> code = NormalCode(normal);
  return NormalOf(code[0], code[1]);
}

}  // namespace lsmvs::internal
