#include "lsmvs/mesh/textured_ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lsmvs/image/image_file.h"
#include "lsmvs/mesh/files/ply_mesh.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

using internal::kRemedy;

constexpr std::string_view kPageComment = "TextureFile ";

std::string Trimmed(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t");
  return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

std::filesystem::path FindPage(const std::filesystem::path& mesh_path, std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');  // of Windows
  const std::filesystem::path folder = mesh_path.parent_path(), page = name;
  const std::filesystem::path candidates[] = {folder / page, folder / page.filename()};
  for (const std::filesystem::path& candidate : candidates) {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(candidate, ignored)) return candidate;
  }
  throw InputError(mesh_path.string(),
                   fmt::format("its texture {} is missing", candidates[1].string()),
                   "put the file there");
}

std::vector<std::filesystem::path> FindPages(const std::filesystem::path& path,
                                             const std::vector<std::string>& comments) {
  std::vector<std::filesystem::path> pages;
  for (const std::string& comment : comments) {
    if (!comment.starts_with(kPageComment)) continue;
    const std::string name = Trimmed(comment.substr(kPageComment.size()));
    if (name.empty()) throw InputError(path.string(), "names no file in TextureFile", kRemedy);
    pages.push_back(FindPage(path, name));
  }
  if (pages.size() > std::numeric_limits<uint16_t>::max()) {
    throw InputError(path.string(), "has more than 65,535 textures", "merge its textures");
  }
  return pages;
}

Eigen::Vector2i LargestSize(const std::vector<std::filesystem::path>& pages) {
  Eigen::Vector2i largest = Eigen::Vector2i::Zero();
  for (const std::filesystem::path& page : pages) {
    const std::optional<ImageFileInfo> info = InspectImageFile(page.string());
    if (!info || info->size.minCoeff() <= 0) {
      throw InputError(page.string(), "is no PNG, JPEG or TIFF image",
                       "save the texture again as PNG");
    }
    largest = largest.cwiseMax(info->size);
  }
  return largest;
}

// Positions of u and v among the scalar properties of an element, or nothing.
std::optional<std::array<int, 2>> FindVertexTexcoord(const PlyElement& vertex) {
  constexpr std::array<std::array<const char*, 2>, 3> kNames = {
      {{"texture_u", "texture_v"}, {"u", "v"}, {"s", "t"}}};
  for (const auto& [u_name, v_name] : kNames) {
    const int u = vertex.Find(u_name), v = vertex.Find(v_name);
    const auto is_scalar = [&](int p) { return p >= 0 && !vertex.properties[p].is_list; };
    if (is_scalar(u) && is_scalar(v)) return std::array<int, 2>{u, v};
  }
  return std::nullopt;
}

// Collects texture coordinates beside the faces of a PlyMeshCollector, whose fans it follows.
class TextureCollector {
 public:
  TextureCollector(const PlyReader& reader, const std::filesystem::path& path,
                   TexturedMesh* textured)
      : path_(path.string()), textured_(textured) {
    vertex_uv_ = FindVertexTexcoord(*reader.FindElement("vertex"));
    const PlyElement* face = reader.FindElement("face");
    if (face == nullptr) return;
    texcoord_ = face->Find("texcoord");
    if (texcoord_ >= 0 && !face->properties[texcoord_].is_list) texcoord_ = -1;
    page_ = face->Find("texnumber");
    if (page_ >= 0 && face->properties[page_].is_list) page_ = -1;
    if (texcoord_ < 0 && !vertex_uv_) {
      throw InputError(path_, "names a texture but has no texture coordinates", kRemedy);
    }
  }

  void AddVertex(const PlyReader::Row& row) {
    if (texcoord_ >= 0 || !vertex_uv_) return;
    vertex_texcoords_.push_back(Pixels(row.values[row.first[(*vertex_uv_)[0]]],
                                       row.values[row.first[(*vertex_uv_)[1]]], row.index));
  }

  void AddFace(const PlyReader::Row& row, size_t num_corners) {
    const uint16_t page = Page(row);
    const auto corner = [&](size_t c) {
      const size_t i = row.first[texcoord_] + 2 * c;
      return Pixels(row.values[i], row.values[i + 1], row.index);
    };
    if (texcoord_ >= 0 && row.first[texcoord_ + 1] - row.first[texcoord_] != 2 * num_corners) {
      throw InputError(path_,
                       fmt::format("face {} has {} corners and {} numbers in texcoord", row.index,
                                   num_corners, row.first[texcoord_ + 1] - row.first[texcoord_]),
                       kRemedy);
    }
    for (size_t c = 2; c < num_corners; ++c) {
      textured_->page_idx.push_back(page);
      if (texcoord_ >= 0) textured_->texcoords.push_back({corner(0), corner(c - 1), corner(c)});
    }
  }

  // After the mesh was taken: its indices are valid.
  void Finish() {
    if (texcoord_ >= 0) return;
    for (const Eigen::Vector3i& face : textured_->mesh.faces) {
      textured_->texcoords.push_back(
          {vertex_texcoords_[face[0]], vertex_texcoords_[face[1]], vertex_texcoords_[face[2]]});
    }
  }

 private:
  Eigen::Vector2f Pixels(double u, double v, uint64_t row) const {
    const Eigen::Vector2f pixels(static_cast<float>(u * textured_->page_width),
                                 static_cast<float>((1 - v) * textured_->page_height));
    if (pixels.allFinite()) return pixels;
    throw InputError(path_,
                     fmt::format("{} {} has texture coordinates that are not finite",
                                 texcoord_ >= 0 ? "face" : "vertex", row),
                     kRemedy);
  }

  uint16_t Page(const PlyReader::Row& row) const {
    const double page = page_ >= 0 ? row.values[row.first[page_]] : 0;
    if (page >= 0 && page < static_cast<double>(textured_->pages.size())) {
      return static_cast<uint16_t>(page);
    }
    throw InputError(path_,
                     fmt::format("face {} has texnumber {}, but there are {} textures", row.index,
                                 page, textured_->pages.size()),
                     kRemedy);
  }

  std::string path_;
  TexturedMesh* textured_;
  int texcoord_ = -1, page_ = -1;
  std::optional<std::array<int, 2>> vertex_uv_;
  std::vector<Eigen::Vector2f> vertex_texcoords_;
};

void CheckBaseNames(const TexturedMesh& textured) {
  std::set<std::string> names;
  for (const std::filesystem::path& page : textured.pages) names.insert(page.filename().string());
  LSMVS_CHECK_EQ(names.size(), textured.pages.size());
}

}  // namespace

TexturedMesh ReadTexturedPly(const std::filesystem::path& path, const Eigen::Vector3d& world_offset,
                             NotFinite not_finite) {
  PlyReader reader(path);
  internal::PlyMeshCollector collector(reader, path, world_offset, not_finite);
  TexturedMesh textured;
  textured.pages = FindPages(path, reader.comments());
  const Eigen::Vector2i size = LargestSize(textured.pages);
  textured.page_width = size[0];
  textured.page_height = size[1];
  std::optional<TextureCollector> texture;
  if (textured.has_texture()) texture.emplace(reader, path, &textured);
  reader.Read({{"vertex",
                [&](const PlyReader::Row& row) {
                  collector.AddVertex(row);
                  if (texture) texture->AddVertex(row);
                }},
               {"face", [&](const PlyReader::Row& row) {
                  const size_t num_corners = collector.AddFace(row);
                  if (texture) texture->AddFace(row, num_corners);
                }}});
  textured.mesh = collector.Take();
  if (texture) texture->Finish();
  return textured;
}

void WriteTexturedPly(const std::filesystem::path& path, const TexturedMesh& textured,
                      const Eigen::Vector3d& world_offset) {
  std::string fault;
  if (!textured.Check(&fault)) throw std::logic_error("textured mesh: " + fault);
  CheckBaseNames(textured);
  if (!textured.has_texture()) return WriteMeshPly(path, textured.mesh, world_offset);

  const internal::PlyVertexWriter vertices(textured.mesh, world_offset);
  const bool has_page_numbers = textured.pages.size() > 1;
  AtomicFile file(path);
  file.Write("ply\nformat binary_little_endian 1.0\n");
  for (const std::filesystem::path& page : textured.pages) {
    file.Write(fmt::format("comment {}{}\n", kPageComment, page.filename().string()));
  }
  file.Write(vertices.Header());
  file.Write(
      fmt::format("element face {}\nproperty list uchar int vertex_indices\n"
                  "property list uchar float texcoord\n{}end_header\n",
                  textured.mesh.faces.size(), has_page_numbers ? "property int texnumber\n" : ""));
  vertices.WriteRows(&file);
  for (size_t f = 0; f < textured.mesh.faces.size(); ++f) {
    file.WriteValue(uint8_t{3});
    file.Write(textured.mesh.faces[f].data(), 3 * sizeof(int));
    file.WriteValue(uint8_t{6});
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector2d uv = textured.NormalizedTexcoord(f, c);
      file.WriteValue(static_cast<float>(uv[0]));
      file.WriteValue(static_cast<float>(1 - uv[1]));
    }
    if (has_page_numbers) file.WriteValue(static_cast<int32_t>(textured.page_idx[f]));
  }
  file.Commit();
}

}  // namespace lsmvs
