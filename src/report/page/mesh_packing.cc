#include "lsmvs/report/page/mesh_packing.h"

#include <zlib.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

constexpr double kNumSteps = (1 << 24) - 1;

void PackAxis(const TriangleMesh& mesh, int axis, double origin, double step,
              std::vector<uint8_t>* bytes) {
  const size_t count = mesh.vertices.size(), begin = bytes->size();
  bytes->resize(begin + 3 * count);
  uint8_t* out = bytes->data() + begin;
  uint32_t last = 0;
  for (size_t v = 0; v < count; ++v) {
    const double place = (mesh.vertices[v][axis] - origin) / step;
    const uint32_t value = static_cast<uint32_t>(std::lround(std::clamp(place, 0.0, kNumSteps)));
    const uint32_t difference = value - last;
    for (size_t plane = 0; plane < 3; ++plane) {
      out[plane * count + v] = static_cast<uint8_t>(difference >> (8 * plane));
    }
    last = value;
  }
}

// One byte a vertex, as differences.
template <class Value>
void PackPlane(size_t count, const Value& value, std::vector<uint8_t>* bytes) {
  uint8_t last = 0;
  for (size_t v = 0; v < count; ++v) {
    const uint8_t next = value(v);
    bytes->push_back(static_cast<uint8_t>(next - last));
    last = next;
  }
}

void PackFaces(const std::vector<Eigen::Vector3i>& faces, std::vector<uint8_t>* bytes) {
  int last = 0;
  for (const Eigen::Vector3i& face : faces) {
    for (int k = 0; k < 3; ++k) {
      const int difference = face[k] - last;
      last = face[k];
      uint32_t code =
          (static_cast<uint32_t>(difference) << 1) ^ static_cast<uint32_t>(difference < 0 ? -1 : 0);
      for (; code >= 128; code >>= 7) bytes->push_back(static_cast<uint8_t>(code | 128));
      bytes->push_back(static_cast<uint8_t>(code));
    }
  }
}

void PackTexcoords(const std::vector<std::array<Eigen::Vector2f, 3>>& texcoords, int axis,
                   float size, std::vector<uint8_t>* bytes) {
  const size_t count = 3 * texcoords.size(), begin = bytes->size();
  bytes->resize(begin + 2 * count);
  uint8_t* out = bytes->data() + begin;
  uint16_t last = 0;
  for (size_t i = 0; i < count; ++i) {
    const float place = texcoords[i / 3][i % 3][axis] / size;
    const auto value = static_cast<uint16_t>(std::lround(65535 * std::clamp(place, 0.0f, 1.0f)));
    const auto difference = static_cast<uint16_t>(value - last);
    out[i] = static_cast<uint8_t>(difference & 255);
    out[count + i] = static_cast<uint8_t>(difference >> 8);
    last = value;
  }
}

uint8_t ErrorByte(float error) {
  if (std::isnan(error)) return 255;
  return static_cast<uint8_t>(std::lround(254 * std::clamp(error, 0.0f, 1.0f)));
}

std::vector<uint8_t> Deflate(const std::vector<uint8_t>& bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<uint8_t> packed(size);
  const int code =
      compress2(packed.data(), &size, bytes.data(), static_cast<uLong>(bytes.size()), 6);
  LSMVS_CHECK_EQ(code, Z_OK);
  packed.resize(size);
  return packed;
}

}  // namespace

PackedMesh PackMesh(const TriangleMesh& mesh, const std::vector<float>& errors,
                    const std::vector<std::array<Eigen::Vector2f, 3>>& texcoords,
                    const Eigen::Vector2i& texture_size) {
  LSMVS_CHECK(texcoords.empty() || texcoords.size() == mesh.faces.size());
  LSMVS_CHECK(errors.empty() || errors.size() == mesh.vertices.size());
  PackedMesh packed;
  packed.num_vertices = mesh.vertices.size();
  packed.num_faces = mesh.faces.size();
  packed.has_colors = !mesh.vertex_colors.empty();
  packed.has_errors = !errors.empty();
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& x : mesh.vertices) box.extend(x);
  if (!box.isEmpty()) {
    packed.origin = box.min();
    const double extent = box.sizes().maxCoeff();
    if (extent > 0) packed.step = extent / kNumSteps;
  }
  std::vector<uint8_t> bytes;
  for (int axis = 0; axis < 3; ++axis) {
    PackAxis(mesh, axis, packed.origin[axis], packed.step, &bytes);
  }
  for (int k = 0; packed.has_colors && k < 3; ++k) {
    PackPlane(
        packed.num_vertices, [&](size_t v) { return mesh.vertex_colors[v][k]; }, &bytes);
  }
  if (packed.has_errors) {
    PackPlane(
        packed.num_vertices, [&](size_t v) { return ErrorByte(errors[v]); }, &bytes);
  }
  PackFaces(mesh.faces, &bytes);
  packed.has_texture = !texcoords.empty();
  for (int axis = 0; packed.has_texture && axis < 2; ++axis) {
    PackTexcoords(texcoords, axis, static_cast<float>(texture_size[axis]), &bytes);
  }
  packed.bytes = Deflate(bytes);
  return packed;
}

std::string Base64(const std::vector<uint8_t>& bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t left = std::min<size_t>(3, bytes.size() - i);
    uint32_t word = 0;
    for (size_t k = 0; k < 3; ++k) word = word << 8 | (k < left ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k) {
      text.push_back(k <= left ? kDigits[word >> (18 - 6 * k) & 63] : '=');
    }
  }
  return text;
}

}  // namespace lsmvs
