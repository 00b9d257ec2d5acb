#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// A mesh in few bytes, as src/report/web/src/unpack.js reads it: a zlib stream (RFC 1950) of
//   positions: per axis, differences between successive vertices in steps of `step`, in three
//   planes of low, middle, high bytes; colours (if any): per channel, differences modulo 256;
//   errors (if any): a byte a vertex, 0..254 for 0..1, 255 for unknown, differences modulo 256;
//   faces: differences between successive indices, zigzag-coded, 7 bits a byte, low first, high
//   bit: more follows;
//   texture (if any): u, then v of each face's corners, 0..65535 for 0..1 of the page (y down), as
//   differences modulo 65536 in two planes of low and high bytes.
struct PackedMesh {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double step = 1;  // of a coordinate: 2^-24 of the size of the mesh
  size_t num_vertices = 0, num_faces = 0;
  bool has_colors = false, has_errors = false, has_texture = false;
  std::vector<uint8_t> bytes;
};

// `errors` is empty or has one value a vertex; `texcoords` is empty or #F, in pixels of a page of
// `texture_size`. Vertices must be finite.
PackedMesh PackMesh(const TriangleMesh& mesh, const std::vector<float>& errors,
                    const std::vector<std::array<Eigen::Vector2f, 3>>& texcoords = {},
                    const Eigen::Vector2i& texture_size = Eigen::Vector2i::Zero());

// Base64 of RFC 4648, with padding.
std::string Base64(const std::vector<uint8_t>& bytes);

}  // namespace lsmvs
