#include "lsmvs/colmap_adapter/undistorted_masks.h"

#include <fmt/format.h>

#include <fstream>
#include <sstream>
#include <unordered_map>

#include "lsmvs/colmap_adapter/model/temporary_workspace.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/image/image_codec.h"
#include "lsmvs/image/image_store.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/hash.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

// A photo with a mask file, or transparent pixels, or both.
struct MaskedPhoto {
  const SparseModel::Image* image = nullptr;
  const SparseModel::Camera* camera = nullptr;
  Eigen::Vector2i undistorted_size = Eigen::Vector2i::Zero();
  std::string mask_path;   // empty: none
  std::string photo_path;  // if it has an alpha channel; else empty

  std::string MaskName() const { return image->name + ".png"; }
  Eigen::Vector2i PhotoSize() const {
    return {static_cast<int>(camera->width), static_cast<int>(camera->height)};
  }
  // Whether the mask was made for the undistorted photo.
  bool IsOfUndistorted() const {
    if (mask_path.empty()) return false;
    const Eigen::Vector2i size = ReadImageSize(mask_path);
    if (size != PhotoSize() && size != undistorted_size) {
      throw InputError(mask_path,
                       fmt::format("is {} x {} pixels, but its photo is {} x {}", size.x(),
                                   size.y(), PhotoSize().x(), PhotoSize().y()),
                       "make the mask of its photo's size, or remove it");
    }
    return size != PhotoSize();
  }
};

template <class Record, class Id>
std::unordered_map<uint64_t, const Record*> ById(const std::vector<Record>& records, Id id) {
  std::unordered_map<uint64_t, const Record*> map;
  for (const Record& record : records) map[static_cast<uint64_t>(record.*id)] = &record;
  return map;
}

std::vector<MaskedPhoto> FindMaskedPhotos(const SparseModel& model, const SparseModel& undistorted,
                                          const WorkspaceEntry& entry, const MaskOptions& options) {
  const auto cameras = ById(model.cameras, &SparseModel::Camera::camera_id);
  const auto new_cameras = ById(undistorted.cameras, &SparseModel::Camera::camera_id);
  std::unordered_map<std::string, const SparseModel::Camera*> new_camera_of_name;
  for (const SparseModel::Image& image : undistorted.images) {
    new_camera_of_name[image.name] = new_cameras.at(static_cast<uint64_t>(image.camera_id));
  }
  std::vector<MaskedPhoto> photos;
  for (const SparseModel::Image& image : model.images) {
    const auto found = new_camera_of_name.find(image.name);
    if (found == new_camera_of_name.end()) continue;
    MaskedPhoto photo;
    photo.image = &image;
    photo.camera = cameras.at(static_cast<uint64_t>(image.camera_id));
    photo.undistorted_size = {static_cast<int>(found->second->width),
                              static_cast<int>(found->second->height)};
    photo.mask_path = MaskPath(options.mask_folder, image.name);
    const fs::path file = entry.image_folder / image.name;
    const bool has_alpha =
        options.alpha_is_mask && fs::is_regular_file(file) && HasAlpha(file.string());
    if (has_alpha) photo.photo_path = file.string();
    if (has_alpha || !photo.mask_path.empty()) photos.push_back(std::move(photo));
  }
  return photos;
}

ByteImage UsedPixels(const MaskedPhoto& photo) {
  const Eigen::Vector2i size = photo.PhotoSize();
  ByteImage used(size.x(), size.y(), uint8_t{255});
  const auto intersect = [&](const ByteImage& other) {
    for (size_t i = 0; i < std::min(used.size(), other.size()); ++i) {
      used.pixels[i] = used.pixels[i] & other.pixels[i];
    }
  };
  if (!photo.mask_path.empty()) intersect(ReadMask(photo.mask_path));
  if (!photo.photo_path.empty()) intersect(ReadAlphaMask(photo.photo_path));
  return used;
}

void WriteMask(const fs::path& path, const ByteImage& used) {
  ColorImage image(used.width, used.height);
  for (size_t i = 0; i < used.size(); ++i) image.pixels[i].setConstant(used.pixels[i]);
  fs::create_directories(path.parent_path());
  WritePng(path, image);
}

// The masks as photos of a model without points.
void WriteMaskProject(const std::vector<MaskedPhoto>& photos, const fs::path& folder) {
  SparseModel model;
  std::unordered_map<uint64_t, bool> known_cameras;
  for (const MaskedPhoto& photo : photos) {
    if (!known_cameras[static_cast<uint64_t>(photo.camera->camera_id)]) {
      known_cameras[static_cast<uint64_t>(photo.camera->camera_id)] = true;
      model.cameras.push_back(*photo.camera);
    }
    SparseModel::Image image = *photo.image;
    image.name = photo.MaskName();
    image.points2d.clear();
    image.num_points2d = 0;
    model.images.push_back(std::move(image));
    WriteMask(folder / "images" / photo.MaskName(), UsedPixels(photo));
  }
  WriteSparseModel(folder / "sparse", model);
}

// COLMAP interpolates; a pixel counts as used if most of what it was made of is.
void TakeUndistortedMask(const fs::path& from, const fs::path& to) {
  const ColorImage image = ReadColors(from);
  ByteImage used(image.width, image.height);
  for (size_t i = 0; i < used.size(); ++i) used.pixels[i] = image.pixels[i].x() >= 128 ? 255 : 0;
  WriteMask(to, used);
}

void UndistortAll(const std::vector<MaskedPhoto>& photos, const fs::path& folder,
                  const fs::path& log_path, const ColmapRunner& runner, const RunContext& context) {
  const fs::path project = folder / "project", output = folder / "undistorted";
  WriteMaskProject(photos, project);
  runner.Run(
      {"image_undistorter", "--image_path", (project / "images").string(), "--input_path",
       (project / "sparse").string(), "--output_path", output.string(), "--output_type", "COLMAP"},
      log_path, context);
  for (const MaskedPhoto& photo : photos) {
    TakeUndistortedMask(output / "images" / photo.MaskName(), folder / photo.MaskName());
  }
  fs::remove_all(project);
  fs::remove_all(output);
}

// What the masks are made from: when it stays, so do they.
std::string Fingerprint(const WorkspaceEntry& entry, const std::vector<MaskedPhoto>& photos) {
  std::string text;
  for (const char* name : {"cameras.bin", "images.bin", "cameras.txt", "images.txt"}) {
    const fs::path path = entry.sparse_folder / name;
    if (fs::exists(path)) text += fmt::format("{} {}\n", name, HashFile(path));
  }
  for (const MaskedPhoto& photo : photos) {
    text += photo.image->name;
    if (!photo.mask_path.empty()) text += fmt::format(" mask {}", HashFile(photo.mask_path));
    if (!photo.photo_path.empty()) text += fmt::format(" alpha {}", HashFile(photo.photo_path));
    text += "\n";
  }
  return text;
}

std::string ReadText(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void CheckMaskFolder(const std::string& folder) {
  if (folder.empty() || fs::is_directory(folder)) return;
  throw InputError(folder, "the folder of the masks is missing", "correct --mask_path");
}

}  // namespace

std::string PrepareMasks(const WorkspaceEntry& entry, const MaskOptions& options,
                         const ColmapRunner& runner, const RunContext& context) {
  if (entry.sparse_folder.empty()) return options.mask_folder;
  CheckMaskFolder(options.mask_folder);
  const SparseModel model = ReadSparseModel(entry.sparse_folder, {.keep_points2d = false});
  const SparseModel undistorted =
      ReadSparseModel(entry.workspace.SparseFolder(), {.keep_points2d = false});
  std::vector<MaskedPhoto> photos = FindMaskedPhotos(model, undistorted, entry, options);
  if (photos.empty()) return options.mask_folder;
  const fs::path folder = entry.workspace.RunFolder() / "masks";
  constexpr const char* kFingerprintFile = "made_from.txt";
  const std::string fingerprint = Fingerprint(entry, photos);
  if (ReadText(folder / kFingerprintFile) == fingerprint) return folder.string();
  TemporaryWorkspace temporary(folder);
  for (const MaskedPhoto& photo : photos) {
    if (photo.IsOfUndistorted()) {
      WriteMask(temporary.folder() / photo.MaskName(), ReadMask(photo.mask_path));
    }
  }
  std::erase_if(photos, [](const MaskedPhoto& photo) { return photo.IsOfUndistorted(); });
  if (!photos.empty()) {
    UndistortAll(photos, temporary.folder(), entry.workspace.LogFolder() / "masks.log", runner,
                 context);
  }
  WriteFileAtomically(temporary.folder() / kFingerprintFile, fingerprint);
  temporary.Keep();
  return folder.string();
}

}  // namespace lsmvs
