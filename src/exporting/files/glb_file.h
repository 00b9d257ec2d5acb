#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lsmvs/exporting/page_files.h"
#include "lsmvs/image/raster.h"

namespace lsmvs {

// Triangles of one material.
struct GlbPart {
  std::vector<Eigen::Vector3f> positions;  // #v, not empty
  std::vector<Eigen::Vector2f> uv;         // #v in [0, 1], y down; or empty
  std::vector<Color> colors;               // #v, sRGB; or empty. Not beside `uv`
  std::vector<Eigen::Vector3i> faces;      // not empty
  int image = -1;                          // index into GlbModel::images, or -1
};

// A binary glTF 2.0 file: parts under one node.
struct GlbModel {
  std::vector<GlbPart> parts;
  std::vector<EncodedImage> images;
  // From the positions to glTF's frame: y up, the viewer at +z.
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  // What was subtracted from the world's coordinates; written as the scene's extras.offset unless
  // it is zero.
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  // Quantise to 16 bits (positions: of the longest side of the model's box; texture coordinates: of
  // a page) and compress for EXT_meshopt_compression and KHR_mesh_quantization, which a reader
  // needs then: about a quarter of the bytes, without the textures.
  bool compress = false;
};

// Writes the model with unlit materials (KHR_materials_unlit): the colours are those of the photos.
// Bounds of positions are exact. Vertex colours become linear light in 16 bits, as glTF asks for.
// WebP images need EXT_texture_webp of the reader. Images that are files are copied piece by piece.
// The same model gives the same bytes. Atomic. Throws UsageError if the file would exceed 4 GB, the
// limit of the format.
void WriteGlb(const std::filesystem::path& path, const GlbModel& model);

}  // namespace lsmvs
