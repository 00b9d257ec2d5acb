#include "lsmvs/mesh/ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <numeric>
#include <sstream>

#include "lsmvs/mesh/files/ply_mesh.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

using internal::kRemedy;

struct TypeName {
  const char* name;
  PlyType type;
};
constexpr std::array<TypeName, 16> kTypeNames = {{{"char", PlyType::kInt8},
                                                  {"int8", PlyType::kInt8},
                                                  {"uchar", PlyType::kUint8},
                                                  {"uint8", PlyType::kUint8},
                                                  {"short", PlyType::kInt16},
                                                  {"int16", PlyType::kInt16},
                                                  {"ushort", PlyType::kUint16},
                                                  {"uint16", PlyType::kUint16},
                                                  {"int", PlyType::kInt32},
                                                  {"int32", PlyType::kInt32},
                                                  {"uint", PlyType::kUint32},
                                                  {"uint32", PlyType::kUint32},
                                                  {"float", PlyType::kFloat32},
                                                  {"float32", PlyType::kFloat32},
                                                  {"double", PlyType::kFloat64},
                                                  {"float64", PlyType::kFloat64}}};

size_t SizeOf(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return 2;
    case PlyType::kFloat64:
      return 8;
    default:
      return 4;
  }
}

template <class T>
double Load(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

double Decode(PlyType type, const char* bytes) {
  switch (type) {
    case PlyType::kInt8:
      return Load<int8_t>(bytes);
    case PlyType::kUint8:
      return Load<uint8_t>(bytes);
    case PlyType::kInt16:
      return Load<int16_t>(bytes);
    case PlyType::kUint16:
      return Load<uint16_t>(bytes);
    case PlyType::kInt32:
      return Load<int32_t>(bytes);
    case PlyType::kUint32:
      return Load<uint32_t>(bytes);
    case PlyType::kFloat32:
      return Load<float>(bytes);
    case PlyType::kFloat64:
      return Load<double>(bytes);
  }
  return 0;
}

}  // namespace

// The bytes behind a reader, buffered, with the position for messages.
struct PlyReader::Input {
  enum class Format { kAscii, kLittleEndian, kBigEndian };

  explicit Input(const std::string& file_path) : path(file_path), buffer(size_t{1} << 16) {
    file.open(path, std::ios::binary);
    if (!file) throw InputError(path, "cannot be opened", "check that it exists");
  }

  [[noreturn]] void Fail(const std::string& what) const {
    throw InputError(path, what, kRemedy, Position());
  }
  uint64_t Position() const { return buffer_position + next; }

  bool Refill() {
    buffer_position += filled;
    next = filled = 0;
    file.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    filled = static_cast<size_t>(file.gcount());
    return filled > 0;
  }

  void ReadBytes(char* out, size_t count) {
    while (count > 0) {
      if (next == filled && !Refill()) Fail("ends too early");
      const size_t part = std::min(count, filled - next);
      std::memcpy(out, buffer.data() + next, part);
      next += part;
      out += part;
      count -= part;
    }
  }

  // The next `count` bytes, up to the next call: those of the buffer, or a copy in `joined` where
  // its end parts them.
  const char* NextBytes(size_t count, std::vector<char>* joined) {
    if (filled - next >= count) {
      next += count;
      return buffer.data() + next - count;
    }
    joined->resize(count);
    ReadBytes(joined->data(), count);
    return joined->data();
  }

  // A line without its end; false at the end of the file.
  bool ReadLine(std::string* line) {
    line->clear();
    while (next < filled || Refill()) {
      const char c = buffer[next++];
      if (c == '\n') {
        if (!line->empty() && line->back() == '\r') line->pop_back();
        return true;
      }
      line->push_back(c);
      if (line->size() > size_t{1} << 20) Fail("has a line that does not end");
    }
    return !line->empty();
  }

  double ReadAsciiNumber() {
    const auto is_space = [](char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; };
    while ((next < filled || Refill()) && is_space(buffer[next])) ++next;
    char text[64];
    size_t length = 0;
    while ((next < filled || Refill()) && !is_space(buffer[next]) && length < sizeof text) {
      text[length++] = buffer[next++];
    }
    if (length == 0) Fail("ends too early");
    if (length == sizeof text) Fail("has a number that does not end");
    double value = 0;
    const char* begin = text[0] == '+' ? text + 1 : text;
    const auto [last, error] = std::from_chars(begin, text + length, value);
    if (error != std::errc() || last != text + length) {
      Fail("has '" + std::string(text, length) + "' where a number should be");
    }
    return value;
  }

  double ReadNumber(PlyType type) {
    if (format == Format::kAscii) return ReadAsciiNumber();
    char bytes[8];
    const size_t size = SizeOf(type);
    ReadBytes(bytes, size);
    if (format == Format::kBigEndian) std::reverse(bytes, bytes + size);
    return Decode(type, bytes);
  }

  std::string path;
  std::ifstream file;
  std::vector<char> buffer;
  size_t next = 0, filled = 0;
  uint64_t buffer_position = 0;
  Format format = Format::kLittleEndian;
};

int PlyElement::Find(const std::string& property_name) const {
  for (size_t p = 0; p < properties.size(); ++p) {
    if (properties[p].name == property_name) return static_cast<int>(p);
  }
  return -1;
}

PlyReader::PlyReader(const std::filesystem::path& path)
    : path_(path.string()), input_(std::make_unique<Input>(path.string())) {
  ParseHeader();
}

PlyReader::~PlyReader() = default;

const PlyElement* PlyReader::FindElement(const std::string& name) const {
  for (const PlyElement& element : elements_) {
    if (element.name == name) return &element;
  }
  return nullptr;
}

namespace {

std::vector<std::string> Words(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

// Fills `property` from the words of its header line; false if they make no sense.
bool ParseProperty(const std::vector<std::string>& words, PlyProperty* property) {
  const auto type_of = [](const std::string& name, PlyType* type) {
    for (const TypeName& entry : kTypeNames) {
      if (name == entry.name) {
        *type = entry.type;
        return true;
      }
    }
    return false;
  };
  property->name = words.back();
  if (words.size() == 3) return type_of(words[1], &property->type);
  property->is_list = true;
  return words.size() == 5 && words[1] == "list" && type_of(words[2], &property->count_type) &&
         type_of(words[3], &property->type);
}

bool ParseCount(const std::string& text, uint64_t* count) {
  const auto [last, error] = std::from_chars(text.data(), text.data() + text.size(), *count);
  return error == std::errc() && last == text.data() + text.size();
}

}  // namespace

void PlyReader::ParseHeader() {
  std::string line;
  if (!input_->ReadLine(&line) || line != "ply") input_->Fail("is not a PLY file");
  bool has_format = false;
  while (true) {
    if (!input_->ReadLine(&line)) input_->Fail("header ends too early");
    const std::vector<std::string> words = Words(line);
    if (line.starts_with("comment ")) comments_.push_back(line.substr(8));
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() == 3) {
      has_format = true;
      if (words[1] == "ascii") {
        input_->format = Input::Format::kAscii;
      } else if (words[1] == "binary_big_endian") {
        input_->format = Input::Format::kBigEndian;
      } else if (words[1] != "binary_little_endian") {
        input_->Fail("has the unknown format '" + words[1] + "'");
      }
    } else if (words[0] == "element" && words.size() == 3) {
      PlyElement element{words[1], 0, {}};
      if (!ParseCount(words[2], &element.count)) input_->Fail("has a bad element count");
      elements_.push_back(element);
    } else if (words[0] == "property" && words.size() >= 3 && !elements_.empty()) {
      PlyProperty property;
      if (!ParseProperty(words, &property)) input_->Fail("has the bad line '" + line + "'");
      elements_.back().properties.push_back(property);
    } else {
      input_->Fail("has the bad header line '" + line.substr(0, 80) + "'");
    }
  }
  if (!has_format) input_->Fail("has no format line");
}

void PlyReader::Read(const std::map<std::string, Visitor>& visitors) {
  for (const PlyElement& element : elements_) {
    const auto visitor = visitors.find(element.name);
    // Rows without properties take no bytes: a file could claim any number of them.
    if (element.properties.empty() && element.count > 0) {
      input_->Fail("has the element '" + element.name + "' without properties");
    }
    const Visitor visit = visitor == visitors.end() ? [](const Row& /*row*/) {} : visitor->second;
    const bool has_list = std::any_of(element.properties.begin(), element.properties.end(),
                                      [](const PlyProperty& property) { return property.is_list; });
    if (input_->format == Input::Format::kLittleEndian && !has_list) {
      ReadFixedRows(element, visit);
    } else {
      ReadAnyRows(element, visit);
    }
  }
}

void PlyReader::ReadAnyRows(const PlyElement& element, const Visitor& visit) {
  Row row;
  for (; row.index < element.count; ++row.index) {
    row.values.clear();
    row.first.assign(1, 0);
    for (const PlyProperty& property : element.properties) {
      double count = 1;
      if (property.is_list) count = input_->ReadNumber(property.count_type);
      if (!(count >= 0) || count > 1e6) input_->Fail("has a list of impossible length");
      for (int i = 0; i < static_cast<int>(count); ++i) {
        row.values.push_back(input_->ReadNumber(property.type));
      }
      row.first.push_back(row.values.size());
    }
    visit(row);
  }
}

// Most of the large files: three times as fast.
void PlyReader::ReadFixedRows(const PlyElement& element, const Visitor& visit) {
  const size_t num_properties = element.properties.size();
  Row row;
  row.values.resize(num_properties);
  row.first.resize(num_properties + 1);
  std::iota(row.first.begin(), row.first.end(), size_t{0});
  size_t row_bytes = 0;
  for (const PlyProperty& property : element.properties) row_bytes += SizeOf(property.type);
  std::vector<char> joined;
  for (; row.index < element.count; ++row.index) {
    const char* bytes = input_->NextBytes(row_bytes, &joined);
    for (size_t p = 0; p < num_properties; ++p) {
      const PlyType type = element.properties[p].type;
      row.values[p] = Decode(type, bytes);
      bytes += SizeOf(type);
    }
    visit(row);
  }
}

namespace {

void CheckIndices(const std::string& path, const TriangleMesh& mesh) {
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    if (static_cast<size_t>(mesh.faces[f].maxCoeff()) >= mesh.vertices.size()) {
      throw InputError(path,
                       fmt::format("triangle {} names vertex {}, but there are {}", f,
                                   mesh.faces[f].maxCoeff(), mesh.vertices.size()),
                       kRemedy);
    }
  }
}

}  // namespace

namespace internal {

PlyTriple::PlyTriple(const PlyElement& element, const std::array<const char*, 3>& names) {
  for (size_t k = 0; k < 3; ++k) {
    position[k] = element.Find(names[k]);
    if (position[k] >= 0 && element.properties[position[k]].is_list) position[k] = -1;
  }
}

Eigen::Vector3d PlyTriple::Of(const PlyReader::Row& row) const {
  const auto value = [&](size_t k) { return row.values[row.first[position[k]]]; };
  return {value(0), value(1), value(2)};
}

PlyMeshCollector::PlyMeshCollector(const PlyReader& reader, const std::filesystem::path& path,
                                   const Eigen::Vector3d& world_offset, NotFinite not_finite)
    : path_(path.string()), world_offset_(world_offset), not_finite_(not_finite) {
  const PlyElement* vertex = reader.FindElement("vertex");
  if (vertex == nullptr) throw InputError(path_, "has no vertices", kRemedy);
  position_ = PlyTriple(*vertex, {"x", "y", "z"});
  normal_ = PlyTriple(*vertex, {"nx", "ny", "nz"});
  color_ = PlyTriple(*vertex, {"red", "green", "blue"});
  // PMVS's names.
  if (!color_) color_ = PlyTriple(*vertex, {"diffuse_red", "diffuse_green", "diffuse_blue"});
  quality_ = vertex->Find("quality");
  if (quality_ >= 0 && vertex->properties[quality_].is_list) quality_ = -1;
  if (!position_) throw InputError(path_, "has no x, y, z", kRemedy);
  const PlyElement* face = reader.FindElement("face");
  if (face == nullptr) return;
  indices_ = face->Find("vertex_indices");
  if (indices_ < 0) indices_ = face->Find("vertex_index");
  if (face->count > 0 && (indices_ < 0 || !face->properties[indices_].is_list)) {
    throw InputError(path_, "has faces without vertex_indices", kRemedy);
  }
}

void PlyMeshCollector::AddVertex(const PlyReader::Row& row) {
  const Eigen::Vector3d x = position_.Of(row);
  if (not_finite_ == NotFinite::kRefuse && !x.allFinite()) {
    throw InputError(path_, fmt::format("vertex {} is not finite", row.index), kRemedy);
  }
  mesh_.vertices.push_back(x - world_offset_);
  if (normal_) mesh_.vertex_normals.push_back(normal_.Of(row).cast<float>());
  if (color_) mesh_.vertex_colors.push_back(PlyColor(color_.Of(row)));
  if (quality_ >= 0) {
    mesh_.vertex_quality.push_back(static_cast<float>(row.values[row.first[quality_]]));
  }
}

// Indices are checked later: faces may come before the vertices.
size_t PlyMeshCollector::AddFace(const PlyReader::Row& row) {
  const size_t begin = row.first[indices_], end = row.first[indices_ + 1];
  for (size_t i = begin; i < end; ++i) {
    if (!(row.values[i] >= 0 && row.values[i] <= std::numeric_limits<int>::max())) {
      throw InputError(path_, fmt::format("face {} has an impossible index", row.index), kRemedy);
    }
  }
  const auto index = [&](size_t i) { return static_cast<int>(row.values[i]); };
  for (size_t i = begin + 2; i < end; ++i) {
    mesh_.faces.emplace_back(index(begin), index(i - 1), index(i));
  }
  return end - begin;
}

TriangleMesh PlyMeshCollector::Take() {
  CheckIndices(path_, mesh_);
  return std::move(mesh_);
}

PlyVertexWriter::PlyVertexWriter(const TriangleMesh& mesh, const Eigen::Vector3d& world_offset)
    : mesh_(mesh), world_offset_(world_offset), as_double_(!world_offset.isZero(0.0)) {
  if (has_normals()) LSMVS_CHECK_EQ(mesh.vertex_normals.size(), mesh.vertices.size());
  if (has_colors()) LSMVS_CHECK_EQ(mesh.vertex_colors.size(), mesh.vertices.size());
  if (has_quality()) LSMVS_CHECK_EQ(mesh.vertex_quality.size(), mesh.vertices.size());
}

std::string PlyVertexWriter::Header() const {
  std::string header = fmt::format("element vertex {}\n", mesh_.vertices.size());
  for (const char* name : {"x", "y", "z"}) {
    header += fmt::format("property {} {}\n", as_double_ ? "double" : "float", name);
  }
  if (has_normals()) header += "property float nx\nproperty float ny\nproperty float nz\n";
  if (has_colors()) header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  if (has_quality()) header += "property float quality\n";
  return header;
}

void PlyVertexWriter::WriteRows(AtomicFile* file) const {
  for (size_t v = 0; v < mesh_.vertices.size(); ++v) {
    const Eigen::Vector3d x = mesh_.vertices[v] + world_offset_;
    if (as_double_) {
      file->Write(x.data(), 3 * sizeof(double));
    } else {
      const Eigen::Vector3f x_float = x.cast<float>();
      file->Write(x_float.data(), 3 * sizeof(float));
    }
    if (has_normals()) file->Write(mesh_.vertex_normals[v].data(), 3 * sizeof(float));
    if (has_colors()) file->Write(mesh_.vertex_colors[v].data(), 3);
    if (has_quality()) file->WriteValue(mesh_.vertex_quality[v]);
  }
}

}  // namespace internal

TriangleMesh ReadMeshPly(const std::filesystem::path& path, const Eigen::Vector3d& world_offset,
                         NotFinite not_finite) {
  PlyReader reader(path);
  internal::PlyMeshCollector collector(reader, path, world_offset, not_finite);
  reader.Read({{"vertex", [&](const PlyReader::Row& row) { collector.AddVertex(row); }},
               {"face", [&](const PlyReader::Row& row) { collector.AddFace(row); }}});
  return collector.Take();
}

void WriteMeshPly(const std::filesystem::path& path, const TriangleMesh& mesh,
                  const Eigen::Vector3d& world_offset) {
  const internal::PlyVertexWriter vertices(mesh, world_offset);
  AtomicFile file(path);
  file.Write("ply\nformat binary_little_endian 1.0\n" + vertices.Header());
  file.Write(fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                         mesh.faces.size()));
  vertices.WriteRows(&file);
  for (const Eigen::Vector3i& face : mesh.faces) {
    file.WriteValue(uint8_t{3});
    file.Write(face.data(), 3 * sizeof(int));
  }
  file.Commit();
}

Eigen::Matrix<uint8_t, 3, 1> PlyColor(const Eigen::Vector3d& values) {
  Eigen::Matrix<uint8_t, 3, 1> color;
  for (int k = 0; k < 3; ++k) {
    // Not std::clamp: it passes on what is no number, which has no byte.
    color[k] = values[k] > 0 ? static_cast<uint8_t>(std::min(values[k], 255.0)) : uint8_t{0};
  }
  return color;
}

}  // namespace lsmvs
