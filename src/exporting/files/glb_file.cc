#include "lsmvs/exporting/files/glb_file.h"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "lsmvs/exporting/files/glb_compression.h"
#include "lsmvs/exporting/pages/linear_color.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

using Json = nlohmann::ordered_json;

// Codes of glTF (of OpenGL).
constexpr int kUint16 = 5123, kUint32 = 5125, kFloat = 5126;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr int kLinear = 9729, kLinearMipmapLinear = 9987, kClampToEdge = 33071;

template <class Vector>
Json Array(const Vector& vector) {
  Json array = Json::array();
  for (Eigen::Index i = 0; i < vector.size(); ++i) array.push_back(static_cast<double>(vector[i]));
  return array;
}

// Lays the binary chunk out and describes it; then writes both.
class GlbWriter {
 public:
  explicit GlbWriter(const GlbModel& model) : model_(model) {
    if (model.compress) grid_ = FindPositionGrid(model.parts);
    Describe();
  }

  void Write(const std::filesystem::path& path) {
    json_["buffers"] = Json::array({{{"byteLength", offset_}}});
    if (model_.compress) {
      // What readers decode to; it is in no file.
      json_["buffers"].push_back(
          {{"byteLength", decoded_bytes_},
           {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
    }
    std::string json = json_.dump();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const uint64_t total = 12 + 8 + json.size() + 8 + offset_;
    if (total > std::numeric_limits<uint32_t>::max()) {
      throw UsageError(path.string() +
                       ": GLB files hold at most 4 GB; export 3DTILES, or textures as JPEG");
    }
    AtomicFile file(path);
    file.Write("glTF");
    for (const uint64_t word : {uint64_t{2}, total, uint64_t{json.size()}}) {
      file.WriteValue(static_cast<uint32_t>(word));
    }
    file.Write("JSON" + json);
    file.WriteValue(static_cast<uint32_t>(offset_));
    file.Write(std::string_view("BIN\0", 4));
    for (const std::vector<uint8_t>& block : compressed_) {
      file.Write(block.data(), block.size());
      Pad(block.size(), &file);
    }
    if (!model_.compress) {
      for (const GlbPart& part : model_.parts) WritePart(part, &file);
    }
    for (const EncodedImage& image : model_.images) WriteImage(image, &file);
    file.Commit();
  }

 private:
  void Describe() {
    json_["asset"] = {{"version", "2.0"}, {"generator", "lsmvs"}};
    Json required = Json::array();
    bool has_webp = false;
    for (const EncodedImage& image : model_.images) has_webp |= image.mime_type == "image/webp";
    if (has_webp) required.push_back("EXT_texture_webp");
    if (model_.compress) {
      required.push_back("EXT_meshopt_compression");
      required.push_back("KHR_mesh_quantization");
    }
    json_["extensionsUsed"] = Json::array({"KHR_materials_unlit"});
    for (const Json& name : required) json_["extensionsUsed"].push_back(name);
    if (!required.empty()) json_["extensionsRequired"] = required;
    json_["scene"] = 0;
    json_["scenes"] = Json::array({{{"nodes", Json::array({0})}}});
    if (!model_.offset.isZero(0.0)) json_["scenes"][0]["extras"]["offset"] = Array(model_.offset);
    json_["nodes"] = Json::array({Node()});
    json_["meshes"] = Json::array({{{"primitives", Json::array()}}});
    for (const GlbPart& part : model_.parts) {
      // First: it moves what json_ holds.
      const Json primitive = model_.compress ? CompressedPrimitive(part) : Primitive(part);
      json_["meshes"][0]["primitives"].push_back(primitive);
      json_["materials"].push_back(Material(part));
    }
    if (!model_.images.empty()) DescribeTextures();
  }

  Json Node() const {
    Json node = {{"mesh", 0}};
    if (model_.rotation.coeffs() != Eigen::Quaterniond::Identity().coeffs()) {
      node["rotation"] = Array(model_.rotation.normalized().coeffs());  // x, y, z, w
    }
    Eigen::Vector3d translation = model_.translation;
    if (model_.compress) {
      translation += model_.rotation.normalized() * grid_.low;
      node["scale"] = Array(Eigen::Vector3d(Eigen::Vector3d::Constant(grid_.step)));
    }
    if (!translation.isZero(0.0)) node["translation"] = Array(translation);
    return node;
  }

  static Json Material(const GlbPart& part) {
    Json material = {{"extensions", {{"KHR_materials_unlit", Json::object()}}},
                     {"doubleSided", true}};
    Json& surface = material["pbrMetallicRoughness"];
    surface = {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}};
    if (part.image >= 0) surface["baseColorTexture"] = {{"index", part.image}};
    return material;
  }

  Json Primitive(const GlbPart& part) {
    LSMVS_CHECK(!part.positions.empty() && !part.faces.empty());
    const size_t count = part.positions.size();
    Json attributes;
    attributes["POSITION"] = AddPositions(part.positions);
    if (!part.uv.empty()) {
      LSMVS_CHECK_EQ(part.uv.size(), count);
      attributes["TEXCOORD_0"] = AddAccessor(kFloat, "VEC2", count, 8, kArrayBuffer);
    }
    if (!part.colors.empty()) {
      LSMVS_CHECK_EQ(part.colors.size(), count);
      attributes["COLOR_0"] = AddAccessor(kUint16, "VEC4", count, 8, kArrayBuffer);
      json_["accessors"].back()["normalized"] = true;
    }
    const bool is_short = HasShortIndices(part);
    const int indices = AddAccessor(is_short ? kUint16 : kUint32, "SCALAR", 3 * part.faces.size(),
                                    is_short ? 2 : 4, kElementArrayBuffer);
    return {{"attributes", attributes},
            {"indices", indices},
            {"material", json_.contains("materials") ? json_["materials"].size() : 0}};
  }

  Json CompressedPrimitive(const GlbPart& part) {
    LSMVS_CHECK(!part.positions.empty() && !part.faces.empty());
    CompressedPart made = CompressPart(part, grid_);
    Json attributes;
    attributes["POSITION"] = AddCompressed(kUint16, "VEC3", made.num_vertices,
                                           CompressedPart::kPositionBytes, &made.positions);
    json_["accessors"].back()["min"] = Array(made.low);
    json_["accessors"].back()["max"] = Array(made.high);
    if (!made.uv.empty()) {
      attributes["TEXCOORD_0"] =
          AddCompressed(kUint16, "VEC2", made.num_vertices, CompressedPart::kUvBytes, &made.uv);
      json_["accessors"].back()["normalized"] = true;
    }
    if (!made.colors.empty()) {
      attributes["COLOR_0"] = AddCompressed(kUint16, "VEC4", made.num_vertices,
                                            CompressedPart::kColorBytes, &made.colors);
      json_["accessors"].back()["normalized"] = true;
    }
    const int indices = AddCompressed(made.index_bytes == 2 ? kUint16 : kUint32, "SCALAR",
                                      made.num_indices, made.index_bytes, &made.indices);
    return {{"attributes", attributes},
            {"indices", indices},
            {"material", json_.contains("materials") ? json_["materials"].size() : 0}};
  }

  int AddCompressed(int type, const char* shape, size_t count, size_t bytes_each,
                    std::vector<uint8_t>* bytes) {
    const bool are_indices = std::string_view(shape) == "SCALAR";
    Json view = {{"buffer", 1}, {"byteOffset", decoded_bytes_}, {"byteLength", count * bytes_each}};
    if (!are_indices) view["byteStride"] = bytes_each;
    view["target"] = are_indices ? kElementArrayBuffer : kArrayBuffer;
    view["extensions"]["EXT_meshopt_compression"] = {
        {"buffer", 0},
        {"byteOffset", offset_},
        {"byteLength", bytes->size()},
        {"byteStride", bytes_each},
        {"count", count},
        {"mode", are_indices ? "TRIANGLES" : "ATTRIBUTES"}};
    json_["bufferViews"].push_back(std::move(view));
    json_["accessors"].push_back({{"bufferView", json_["bufferViews"].size() - 1},
                                  {"componentType", type},
                                  {"count", count},
                                  {"type", shape}});
    offset_ += Padded(bytes->size());
    decoded_bytes_ += Padded(count * bytes_each);
    compressed_.push_back(std::move(*bytes));
    return static_cast<int>(json_["accessors"].size()) - 1;
  }

  // 65,535 itself would restart a strip.
  static bool HasShortIndices(const GlbPart& part) { return part.positions.size() <= 65535; }

  int AddPositions(const std::vector<Eigen::Vector3f>& positions) {
    Eigen::Vector3f low = positions[0], high = positions[0];
    for (const Eigen::Vector3f& x : positions) {
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
    const int accessor = AddAccessor(kFloat, "VEC3", positions.size(), 12, kArrayBuffer);
    json_["accessors"].back()["min"] = Array(low);
    json_["accessors"].back()["max"] = Array(high);
    return accessor;
  }

  int AddAccessor(int type, const char* shape, size_t count, size_t bytes_each, int target) {
    const int view = AddBufferView(count * bytes_each);
    json_["bufferViews"].back()["target"] = target;
    json_["accessors"].push_back(
        {{"bufferView", view}, {"componentType", type}, {"count", count}, {"type", shape}});
    return static_cast<int>(json_["accessors"].size()) - 1;
  }

  int AddBufferView(uint64_t num_bytes) {
    json_["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", offset_}, {"byteLength", num_bytes}});
    offset_ += Padded(num_bytes);
    return static_cast<int>(json_["bufferViews"].size()) - 1;
  }

  void DescribeTextures() {
    json_["samplers"] = Json::array({{{"magFilter", kLinear},
                                      {"minFilter", kLinearMipmapLinear},
                                      {"wrapS", kClampToEdge},
                                      {"wrapT", kClampToEdge}}});
    for (size_t i = 0; i < model_.images.size(); ++i) {
      const EncodedImage& image = model_.images[i];
      const int view = AddBufferView(image.size());
      json_["images"].push_back({{"bufferView", view}, {"mimeType", image.mime_type}});
      Json texture = {{"sampler", 0}};
      if (image.mime_type == "image/webp") {
        texture["extensions"]["EXT_texture_webp"]["source"] = i;
      } else {
        texture["source"] = i;
      }
      json_["textures"].push_back(texture);
    }
  }

  static uint64_t Padded(uint64_t num_bytes) { return (num_bytes + 3) / 4 * 4; }

  static void Pad(uint64_t num_bytes, AtomicFile* file) {
    file->Write(std::string_view("\0\0\0", Padded(num_bytes) - num_bytes));
  }

  static void WritePart(const GlbPart& part, AtomicFile* file) {
    const size_t count = part.positions.size();
    file->Write(part.positions.data(), 12 * count);
    file->Write(part.uv.data(), 8 * part.uv.size());
    for (const Color& color : part.colors) {
      for (int k = 0; k < 3; ++k) file->WriteValue(LinearShort(color[k]));
      file->WriteValue(uint16_t{65535});
    }
    if (!HasShortIndices(part)) {
      file->Write(part.faces.data(), 12 * part.faces.size());
      return;
    }
    for (const Eigen::Vector3i& face : part.faces) {
      for (const int v : face) file->WriteValue(static_cast<uint16_t>(v));
    }
    Pad(6 * part.faces.size(), file);
  }

  static void WriteImage(const EncodedImage& image, AtomicFile* file) {
    if (image.file.empty()) {
      file->Write(image.bytes.data(), image.bytes.size());
    } else {
      file->WriteContentOf(image.file);
    }
    Pad(image.size(), file);
  }

  const GlbModel& model_;
  Json json_;
  uint64_t offset_ = 0;  // bytes of the binary chunk so far
  PositionGrid grid_;
  std::vector<std::vector<uint8_t>> compressed_;  // blocks of the binary chunk, in order
  uint64_t decoded_bytes_ = 0;
};

}  // namespace

void WriteGlb(const std::filesystem::path& path, const GlbModel& model) {
  GlbWriter(model).Write(path);
}

}  // namespace lsmvs
