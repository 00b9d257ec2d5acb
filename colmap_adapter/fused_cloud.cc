#include "lsmvs/colmap_adapter/fused_cloud.h"

#include <fmt/format.h>

#include <limits>

#include <algorithm>
#include <cerrno>
#include <cmath>

#include "lsmvs/colmap_adapter/files/binary_reader.h"
#include "lsmvs/colmap_adapter/files/image_order.h"
#include "lsmvs/colmap_adapter/files/visibility_file.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

using internal::ImageOrder;
using internal::OrderFit;
using internal::VisibilityFile;

constexpr const char* kCloudRemedy = "run `stereo_fusion` again";
constexpr const char* kPairRemedy =
    "crop with a tool that keeps both, or remove both and fuse again";
// Fits that raise no question, that another order must exceed ours by, and below which nothing
// fits.
constexpr double kGoodFit = 0.9;
constexpr double kClearlyBetter = 0.05;
constexpr double kMinInside = 0.5;

// Reads positions, normals and colours of all points, without views. Positions that are not finite
// stay as they are.
class PointReader {
 public:
  PointReader(const fs::path& path, const Eigen::Vector3d& world_offset)
      : path_(path.string()), world_offset_(world_offset), reader_(path) {
    element_ = reader_.FindElement("vertex");
    if (element_ == nullptr) throw InputError(path_, "has no vertices", kCloudRemedy);
    has_position_ = Find({"x", "y", "z"}, position_);
    has_normal_ = Find({"nx", "ny", "nz"}, normal_);
    has_color_ = Find({"red", "green", "blue"}, color_) ||
                 Find({"diffuse_red", "diffuse_green", "diffuse_blue"}, color_);
    if (!has_position_) throw InputError(path_, "has no x, y, z", kCloudRemedy);
  }

  uint64_t num_points() const { return element_->count; }

  // Behind the points of `cloud`. `num_points()` must have been found to be believable.
  void Append(VisibilityCloud* cloud) {
    const size_t num_points_then = cloud->positions.size() + static_cast<size_t>(num_points());
    cloud->positions.reserve(num_points_then);
    cloud->normals.reserve(num_points_then);
    cloud->colors.reserve(num_points_then);
    reader_.Read({{"vertex", [&](const PlyReader::Row& row) {
                     cloud->positions.push_back(Position(row));
                     cloud->normals.push_back(Normal(row));
                     cloud->colors.push_back(has_color_ ? PlyColor(Values(row, color_))
                                                        : Color::Zero());
                   }}});
  }

  void Visit(const std::function<void(const Eigen::Vector3f&, const Eigen::Vector3f&)>& visit) {
    reader_.Read(
        {{"vertex", [&](const PlyReader::Row& row) { visit(Position(row), Normal(row)); }}});
  }

 private:
  using Columns = std::array<size_t, 3>;

  bool Find(const std::array<const char*, 3>& names, Columns& columns) const {
    for (size_t k = 0; k < 3; ++k) {
      const int column = element_->Find(names[k]);
      if (column < 0 || element_->properties[static_cast<size_t>(column)].is_list) return false;
      columns[k] = static_cast<size_t>(column);
    }
    return true;
  }

  static Eigen::Vector3d Values(const PlyReader::Row& row, const Columns& columns) {
    return {row.values[row.first[columns[0]]], row.values[row.first[columns[1]]],
            row.values[row.first[columns[2]]]};
  }

  Eigen::Vector3f Position(const PlyReader::Row& row) const {
    return (Values(row, position_) - world_offset_).cast<float>();
  }

  Eigen::Vector3f Normal(const PlyReader::Row& row) const {
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    if (has_normal_) normal = Values(row, normal_).cast<float>();
    const float norm = normal.norm();
    // Unit length as promised; what has it already keeps its bytes.
    if (!std::isfinite(norm) || norm < 1e-6f) {
      normal.setZero();
    } else if (std::abs(norm - 1) > 1e-5f) {
      normal /= norm;
    }
    return normal;
  }

  const std::string path_;
  const Eigen::Vector3d world_offset_;
  PlyReader reader_;
  const PlyElement* element_ = nullptr;
  bool has_position_ = false, has_normal_ = false, has_color_ = false;
  Columns position_{}, normal_{}, color_{};
};

// Throws if it is missing.
fs::path VisibilityPathOf(const fs::path& ply_path) {
  const fs::path vis_path = DenseWorkspace::VisibilityPath(ply_path);
  if (!fs::exists(vis_path)) {
    throw InputError(vis_path.string(),
                     "is missing: without it no one knows which images see a point",
                     "put it beside the cloud, or remove the cloud and fuse again");
  }
  return vis_path;
}

struct ChosenOrder {
  ImageOrder order;
  OrderFit fit;
  std::string message;
};

// Of the points from `first_point` on.
ChosenOrder ChooseOrder(const Scene& scene, const DenseWorkspace& workspace,
                        const VisibilityCloud& points, const VisibilityFile& file,
                        size_t first_point) {
  ChosenOrder chosen{internal::SceneOrder(scene), {}, ""};
  chosen.fit = MeasureFit(scene, points, file, first_point, chosen.order);
  if (chosen.fit.inside >= kGoodFit && chosen.fit.facing >= kGoodFit) return chosen;
  double best_total = chosen.fit.Total() + kClearlyBetter;
  for (ImageOrder& order : internal::OtherOrders(scene, workspace.SparseFolder())) {
    const OrderFit fit = MeasureFit(scene, points, file, first_point, order);
    if (fit.Total() <= best_total) continue;
    best_total = fit.Total();
    chosen = {std::move(order), fit, ""};
  }
  const ImageOrder& order = chosen.order;
  if (order.view_idxs != internal::SceneOrder(scene).view_idxs) {
    chosen.message =
        fmt::format("the images of the visibility file are in {}, not in that of registered images",
                    order.name);
  }
  return chosen;
}

// Of the points from `first_point` on, those with finite positions, with their views in the given
// order, numbered from `first_view` on. In place: a cloud is most of what the process holds.
void Join(const ImageOrder& order, size_t first_point, uint32_t first_view, VisibilityFile file,
          VisibilityCloud* cloud) {
  VisibilityCloud& points = *cloud;
  std::vector<uint64_t>& begin = file.begin;
  std::vector<uint32_t>& views = file.image_idxs;
  size_t num_points = first_point;
  uint64_t num_views = begin[first_point];
  for (size_t p = first_point; p < points.positions.size(); ++p) {
    if (!points.positions[p].allFinite()) continue;
    const auto first = views.begin() + static_cast<std::ptrdiff_t>(begin[p]);
    const auto last = views.begin() + static_cast<std::ptrdiff_t>(begin[p + 1]);
    std::transform(first, last, first,
                   [&](uint32_t image) { return first_view + order.view_idxs[image]; });
    std::sort(first, last);
    const auto to = views.begin() + static_cast<std::ptrdiff_t>(num_views);
    begin[num_points] = num_views;  // not read any more: p is at least as large
    num_views += static_cast<uint64_t>(std::move(first, std::unique(first, last), to) - to);
    points.positions[num_points] = points.positions[p];
    points.normals[num_points] = points.normals[p];
    points.colors[num_points] = points.colors[p];
    ++num_points;
  }
  points.positions.resize(num_points);
  points.normals.resize(num_points);
  points.colors.resize(num_points);
  begin.resize(num_points + 1);
  begin.back() = num_views;
  views.resize(num_views);
  points.view_begin = std::move(begin);
  points.view_idxs = std::move(views);
}

}  // namespace

FusedCloudSize ReadFusedCloudSize(const fs::path& ply_path) {
  const fs::path vis_path = VisibilityPathOf(ply_path);
  const uint64_t num_points = PointReader(ply_path, Eigen::Vector3d::Zero()).num_points();
  // Beside the number of points, each has a number of views, and these, in four bytes each.
  const uint64_t num_numbers = (std::max<uint64_t>(8, fs::file_size(vis_path)) - 8) / 4;
  return {num_points, num_numbers - std::min(num_numbers, num_points)};
}

namespace {

// Reads the number of points that a visibility file begins with. Throws InputError if it is
// another.
void ExpectPoints(uint64_t num_points, internal::BinaryReader* visibility) {
  const auto count = visibility->ReadCount<uint64_t>(sizeof(uint32_t), "points");
  if (count != num_points) visibility->Fail("is for another number of points");
}

}  // namespace

void VisitFusedCloud(const fs::path& ply_path, const Eigen::Vector3d& world_offset,
                     const FusedPointVisitor& visit) {
  PointReader reader(ply_path, world_offset);
  internal::BinaryReader visibility(VisibilityPathOf(ply_path), kCloudRemedy);
  ExpectPoints(reader.num_points(), &visibility);
  std::vector<uint32_t> views;
  reader.Visit([&](const Eigen::Vector3f& position, const Eigen::Vector3f& normal) {
    views.resize(visibility.ReadCount<uint32_t>(sizeof(uint32_t), "images of a point"));
    visibility.ReadBytes(views.data(), views.size() * sizeof(uint32_t));
    visit(position, normal, views);
  });
}

FusedCloud ReadFusedCloud(const fs::path& ply_path, const Scene& scene,
                          const DenseWorkspace& workspace) {
  FusedCloud result;
  const AppendedCloud appended = AppendFusedCloud(ply_path, scene, workspace, 0, &result.cloud);
  result.num_dropped = appended.num_dropped;
  result.message = appended.message;
  return result;
}

AppendedCloud AppendFusedCloud(const fs::path& ply_path, const Scene& scene,
                               const DenseWorkspace& workspace, uint32_t first_view,
                               VisibilityCloud* cloud) {
  PointReader reader(ply_path, scene.world_offset);
  const fs::path vis_path = VisibilityPathOf(ply_path);
  const size_t first_point = cloud->size();
  VisibilityFile file{std::move(cloud->view_begin), std::move(cloud->view_idxs)};
  internal::AppendVisibilityFile(vis_path, scene.views.size(), &file);
  if (const size_t count = file.num_points() - first_point; count != reader.num_points()) {
    throw InputError(vis_path.string(),
                     fmt::format("is for {} points, but {} has {}: the cloud was cropped or edited",
                                 count, ply_path.filename().string(), reader.num_points()),
                     kPairRemedy);
  }
  reader.Append(cloud);
  const ChosenOrder chosen = ChooseOrder(scene, workspace, *cloud, file, first_point);
  if (chosen.fit.inside < kMinInside) {
    throw InputError(
        vis_path.string(),
        fmt::format("does not fit the sparse model: only {:.0f} % of the points lie in "
                    "the images that it names",
                    100 * chosen.fit.inside),
        "the cloud belongs to another model; remove both and fuse again");
  }
  const size_t num_points = cloud->size();
  Join(chosen.order, first_point, first_view, std::move(file), cloud);
  AppendedCloud appended{num_points - cloud->size(), chosen.message};
  if (appended.num_dropped > 0) {
    appended.message += fmt::format("{}{} points without finite position were left out",
                                    appended.message.empty() ? "" : "; ", appended.num_dropped);
  }
  return appended;
}

namespace {

// A line that makes the header equally long for any number of points.
std::string Padding(const std::string& count) {
  constexpr size_t kMaxDigits = 20;
  return fmt::format("comment lsmvs{}\n", std::string(kMaxDigits - count.size(), '.'));
}

std::string PlyHeader(uint64_t num_points, bool as_double, bool padded) {
  const char* type = as_double ? "double" : "float";
  const std::string count = fmt::format("{}", num_points);
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\n{}element vertex {}\n"
      "property {} x\nproperty {} y\nproperty {} z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
      padded ? Padding(count) : "", count, type, type, type);
}

bool NeedsDoubles(const Scene& scene) { return !scene.world_offset.isZero(0.0); }

// Of the file: position, normal, colour.
uint64_t BytesPerPoint(const Scene& scene) {
  return 3 * (NeedsDoubles(scene) ? sizeof(double) : sizeof(float)) + 3 * sizeof(float) + 3;
}

void WritePoints(const VisibilityCloud& cloud, const Scene& scene, AtomicFile* file) {
  for (size_t p = 0; p < cloud.size(); ++p) {
    if (NeedsDoubles(scene)) {
      const Eigen::Vector3d x = cloud.positions[p].cast<double>() + scene.world_offset;
      file->Write(x.data(), sizeof x);
    } else {
      file->Write(cloud.positions[p].data(), 3 * sizeof(float));
    }
    file->Write(cloud.normals[p].data(), 3 * sizeof(float));
    file->Write(cloud.colors[p].data(), 3);
  }
}

// Without the number of points that the file begins with.
void WriteViews(const std::vector<uint64_t>& begin, const std::vector<uint32_t>& view_idxs,
                AtomicFile* file) {
  for (size_t p = 0; p + 1 < begin.size(); ++p) {
    const auto count = static_cast<uint32_t>(begin[p + 1] - begin[p]);
    file->WriteValue(count);
    file->Write(view_idxs.data() + begin[p], count * sizeof(uint32_t));
  }
}

void RemoveIfThere(const fs::path& path) {
  std::error_code error;
  fs::remove(path, error);
  if (error) throw FileSystemError(path.string(), "remove the old file", error.value());
}

}  // namespace

FusedCloudWriter::FusedCloudWriter(const fs::path& ply_path, const Scene& scene,
                                   std::optional<uint64_t> num_points)
    : ply_path_(ply_path),
      scene_(scene),
      count_is_known_(num_points.has_value()),
      ply_(ply_path),
      vis_(DenseWorkspace::VisibilityPath(ply_path)) {
  ply_.Write(PlyHeader(num_points.value_or(0), NeedsDoubles(scene), !count_is_known_));
  vis_.WriteValue(uint64_t{0});
}

void FusedCloudWriter::Add(const VisibilityCloud& part) {
  part.CheckConsistent(scene_.views.size());
  WritePoints(part, scene_, &ply_);
  WriteViews(part.view_begin, part.view_idxs, &vis_);
  size_.num_points += part.size();
  size_.num_view_entries += part.view_idxs.size();
}

void FusedCloudWriter::AddFile(const fs::path& ply_path) {
  const FusedCloudSize size = ReadFusedCloudSize(ply_path);
  const size_t header_bytes = PlyHeader(size.num_points, NeedsDoubles(scene_), true).size();
  internal::BinaryReader visibility(VisibilityPathOf(ply_path), kCloudRemedy);
  ExpectPoints(size.num_points, &visibility);
  if (fs::file_size(ply_path) != header_bytes + size.num_points * BytesPerPoint(scene_)) {
    throw InputError(ply_path.string(), "is cut off, or was not made by this program",
                     "remove it and run again");
  }
  ply_.WriteContentOf(ply_path, header_bytes);
  vis_.WriteContentOf(DenseWorkspace::VisibilityPath(ply_path), sizeof(uint64_t));
  size_.num_points += size.num_points;
  size_.num_view_entries += size.num_view_entries;
}

void FusedCloudWriter::Commit() {
  const uint64_t num_points = size_.num_points;
  ply_.Overwrite(0, PlyHeader(num_points, NeedsDoubles(scene_), !count_is_known_));
  vis_.Overwrite(0, {reinterpret_cast<const char*>(&num_points), sizeof num_points});
  RemoveIfThere(ply_path_);
  vis_.Commit();
  ply_.Commit();
}

void WriteFusedCloud(const fs::path& ply_path, const VisibilityCloud& cloud, const Scene& scene) {
  FusedCloudWriter writer(ply_path, scene, cloud.size());
  writer.Add(cloud);
  writer.Commit();
}

PointViews ReadVisibility(const fs::path& vis_path, size_t num_points) {
  internal::VisibilityFile file =
      internal::ReadVisibilityFile(vis_path, std::numeric_limits<uint32_t>::max());
  if (file.num_points() != num_points) {
    throw InputError(
        vis_path.string(),
        fmt::format("is about {} points, but there are {}", file.num_points(), num_points),
        "remove it or make both files again");
  }
  return {std::move(file.begin), std::move(file.image_idxs)};
}

void WriteVisibility(const fs::path& vis_path, const std::vector<uint64_t>& begin,
                     const std::vector<uint32_t>& view_idxs) {
  AtomicFile file(vis_path);
  file.WriteValue(static_cast<uint64_t>(begin.size() - 1));
  WriteViews(begin, view_idxs, &file);
  file.Commit();
}

}  // namespace lsmvs
