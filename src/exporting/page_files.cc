#include "lsmvs/exporting/page_files.h"

#include <fmt/format.h>

#include <array>
#include <fstream>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

// The format of a file by its first bytes; kKeep if it is neither PNG nor JPEG nor WebP.
TextureFormat FormatOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, 12> head{};
  if (!file.read(head.data(), head.size())) {
    throw InputError(path.string(), "cannot be read as an image", "put the texture's file there");
  }
  const std::string_view bytes(head.data(), head.size());
  if (bytes.starts_with("\x89PNG")) return TextureFormat::kPng;
  if (bytes.starts_with("\xff\xd8\xff")) return TextureFormat::kJpeg;
  if (bytes.starts_with("RIFF") && bytes.substr(8) == "WEBP") return TextureFormat::kWebp;
  return TextureFormat::kKeep;
}

TextureFormat TargetFormat(const fs::path& page, const TextureEncoding& encoding) {
  if (encoding.format != TextureFormat::kKeep) return encoding.format;
  return FormatOf(page) == TextureFormat::kJpeg ? TextureFormat::kJpeg : TextureFormat::kPng;
}

const char* MimeType(TextureFormat format) {
  return format == TextureFormat::kJpeg   ? "image/jpeg"
         : format == TextureFormat::kWebp ? "image/webp"
                                          : "image/png";
}

const char* Extension(TextureFormat format) {
  return format == TextureFormat::kJpeg   ? ".jpg"
         : format == TextureFormat::kWebp ? ".webp"
                                          : ".png";
}

bool SameFolder(const fs::path& a, const fs::path& b) {
  return fs::weakly_canonical(fs::absolute(a).parent_path()) ==
         fs::weakly_canonical(fs::absolute(b).parent_path());
}

}  // namespace

uint64_t EncodedImage::size() const { return file.empty() ? bytes.size() : fs::file_size(file); }

EncodedImage EncodeImage(const ColorImage& image, const TextureEncoding& encoding) {
  EncodedImage encoded;
  encoded.mime_type = MimeType(encoding.format);
  encoded.bytes = encoding.format == TextureFormat::kJpeg   ? EncodeJpeg(image, encoding.quality)
                  : encoding.format == TextureFormat::kWebp ? EncodeWebp(image, encoding.quality)
                                                            : EncodePng(image);
  return encoded;
}

EncodedImage EncodePage(const fs::path& page, const TextureEncoding& encoding) {
  const TextureFormat target = TargetFormat(page, encoding);
  if (FormatOf(page) != target) {
    return EncodeImage(ReadColors(page), {target, encoding.quality});
  }
  EncodedImage encoded;
  encoded.file = page;
  encoded.mime_type = MimeType(target);
  return encoded;
}

std::vector<fs::path> PageTargets(const TexturedMesh& textured, const fs::path& mesh_path,
                                  const TextureEncoding& encoding) {
  std::vector<fs::path> targets;
  for (size_t p = 0; p < textured.pages.size(); ++p) {
    const fs::path& page = textured.pages[p];
    const TextureFormat format = TargetFormat(page, encoding);
    if (SameFolder(page, mesh_path) && FormatOf(page) == format) {
      targets.push_back(page);
    } else {
      targets.push_back(mesh_path.parent_path() /
                        fmt::format("{}_{}{}", mesh_path.stem().string(), p, Extension(format)));
    }
  }
  return targets;
}

void WritePages(const TexturedMesh& textured, const std::vector<fs::path>& targets,
                const TextureEncoding& encoding) {
  for (size_t p = 0; p < targets.size(); ++p) {
    std::error_code ignored;
    if (fs::equivalent(targets[p], textured.pages[p], ignored)) continue;
    const EncodedImage encoded = EncodePage(textured.pages[p], encoding);
    if (!encoded.file.empty()) {
      CopyFileAtomically(encoded.file, targets[p]);
    } else {
      WriteFileAtomically(
          targets[p], {reinterpret_cast<const char*>(encoded.bytes.data()), encoded.bytes.size()});
    }
  }
}

}  // namespace lsmvs
