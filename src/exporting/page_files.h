#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lsmvs/image/raster.h"
#include "lsmvs/mesh/textured_mesh.h"

namespace lsmvs {

// How textures are stored in what is exported.
enum class TextureFormat {
  kKeep,  // the bytes of the page's file, if viewers read it (PNG, JPEG); else PNG
  kPng,
  kJpeg,
  kWebp,
};

struct TextureEncoding {
  TextureFormat format = TextureFormat::kKeep;
  int quality = 92;  // of JPEG and WebP, in [1, 100]
};

// An encoded image: either a file's bytes as they are, or bytes in memory.
struct EncodedImage {
  std::filesystem::path file;  // if not empty, its content
  std::vector<uint8_t> bytes;
  std::string mime_type;  // "image/png", ...

  uint64_t size() const;
};

EncodedImage EncodeImage(const ColorImage& image, const TextureEncoding& encoding);
// A page as the encoding wants it. Throws InputError if the file is missing or broken.
EncodedImage EncodePage(const std::filesystem::path& page, const TextureEncoding& encoding);

// Where the pages of a mesh that is written to `mesh_path` will lie: where they are, if that is
// beside it and they need no change; else as <stem of mesh_path>_<number> beside it.
std::vector<std::filesystem::path> PageTargets(const TexturedMesh& textured,
                                               const std::filesystem::path& mesh_path,
                                               const TextureEncoding& encoding);
// Writes the pages that are not at their targets yet.
void WritePages(const TexturedMesh& textured, const std::vector<std::filesystem::path>& targets,
                const TextureEncoding& encoding);

}  // namespace lsmvs
