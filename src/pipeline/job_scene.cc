#include "lsmvs/pipeline/job_scene.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <map>
#include <span>
#include <vector>

#include "lsmvs/execution/job_order.h"
#include "lsmvs/scene/points_by_view.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/valid_options.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "lsmvs-scene 001\n";
constexpr size_t kMagicBytes = kMagic.size();

// The file: magic, sizes, positions of all points, then 32-bit positions of points view by view,
// then the rest as a stream.
struct Sizes {
  uint64_t num_points = 0, num_entries = 0, num_views = 0, file_bytes = 0;
};
using Position = std::array<double, 3>;

// Of a view: the points that its depth map is started from.
struct SeedList {
  uint64_t begin = 0, end = 0;
  // False: the view sees too few points, and these are the ones in its image.
  bool sees_them = true;
};

class SceneWriter {
 public:
  SceneWriter(const fs::path& path, const Reconstruction& reconstruction)
      : reconstruction_(reconstruction), scene_(reconstruction.scene), file_(path) {}

  void Write() {
    Sizes sizes{scene_.points.size(), 0, scene_.views.size(), 0};
    Put(kMagic.data(), kMagic.size());
    Put(sizes);
    for (const SparsePoint& point : scene_.points) {
      const Eigen::Vector3d& x = point.x_in_world;
      Put(Position{x.x(), x.y(), x.z()});
    }
    WriteLists();
    sizes.num_entries = lists_.empty() ? 0 : lists_.back().end;
    PutText(scene_.image_folder);
    PutText(scene_.mask_folder);
    Put(scene_.alpha_is_mask);
    Put(reconstruction_.has_source_rules);
    for (int axis = 0; axis < 3; ++axis) Put(scene_.world_offset[axis]);
    for (size_t v = 0; v < scene_.views.size(); ++v) WriteView(v);
    sizes.file_bytes = num_bytes_;
    file_.Overwrite(kMagicBytes,
                    std::string_view(reinterpret_cast<const char*>(&sizes), sizeof sizes));
    file_.Commit();
  }

 private:
  void Put(const void* data, size_t num_bytes) {
    file_.Write(data, num_bytes);
    num_bytes_ += num_bytes;
  }
  template <class T>
  void Put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    Put(&value, sizeof value);
  }
  void PutText(const std::string& text) {
    Put(uint64_t{text.size()});
    Put(text.data(), text.size());
  }

  void WriteLists() {
    const PointsByView points(scene_);
    uint64_t num_entries = 0;
    for (int v = 0; v < scene_.num_views(); ++v) {
      const bool sees_them = points.Of(v).size() >= kMinPointsOfView;
      const std::vector<uint32_t> in_image =
          sees_them ? std::vector<uint32_t>() : PointsInImage(scene_, v);
      const std::span<const uint32_t> list = sees_them ? points.Of(v) : in_image;
      Put(list.data(), list.size_bytes());
      lists_.push_back({num_entries, num_entries + list.size(), sees_them});
      num_entries += list.size();
    }
  }

  void WriteView(size_t v) {
    const View& view = scene_.views[v];
    const ImageSource& source = reconstruction_.images->source(static_cast<int>(v));
    Put(view.image_id);
    PutText(view.name);
    Put(view.camera);
    for (int i = 0; i < 9; ++i) Put(view.cam_from_world.rotation(i / 3, i % 3));
    for (int i = 0; i < 3; ++i) Put(view.cam_from_world.translation[i]);
    Put(view.has_photo);
    PutText(source.mask_path);
    Put(source.alpha_is_mask);
    Put(reconstruction_.depth_ranges[v]);
    const std::vector<Neighbor>& neighbors = reconstruction_.neighbors[v];
    Put(uint64_t{neighbors.size()});
    for (const Neighbor& neighbor : neighbors) Put(neighbor);
    Put(lists_[v]);
  }

  const Reconstruction& reconstruction_;
  const Scene& scene_;
  AtomicFile file_;
  std::vector<SeedList> lists_;
  uint64_t num_bytes_ = 0;
};

// A file in memory as far as it is looked at.
class MappedFile {
 public:
  explicit MappedFile(const fs::path& path) {
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat info = {};
    if (descriptor < 0 || ::fstat(descriptor, &info) != 0) Fail(path, descriptor);
    size_ = static_cast<size_t>(info.st_size);
    data_ = ::mmap(nullptr, std::max<size_t>(1, size_), PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (data_ == MAP_FAILED) Fail(path, descriptor);
    ::close(descriptor);
  }
  ~MappedFile() { ::munmap(data_, std::max<size_t>(1, size_)); }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const char> bytes() const { return {static_cast<const char*>(data_), size_}; }

 private:
  [[noreturn]] static void Fail(const fs::path& path, int descriptor) {
    const int error = errno;
    if (descriptor >= 0) ::close(descriptor);
    throw InputError(path.string(), std::string("cannot be read: ") + std::strerror(error),
                     "start the run again");
  }

  void* data_ = nullptr;
  size_t size_ = 0;
};

class SceneReader {
 public:
  explicit SceneReader(const fs::path& path) : path_(path), file_(path), bytes_(file_.bytes()) {
    if (std::memcmp(Take(kMagicBytes).data(), kMagic.data(), kMagicBytes) != 0) Fail();
    sizes_ = Get<Sizes>();
    if (sizes_.file_bytes != bytes_.size()) Fail();
    points_ = Take(sizes_.num_points * sizeof(Position));
    entries_ = Take(sizes_.num_entries * sizeof(uint32_t));
  }

  void Read(const std::set<std::string>& view_names, Reconstruction* reconstruction) {
    Scene& scene = reconstruction->scene;
    scene.image_folder = GetText();
    scene.mask_folder = GetText();
    scene.alpha_is_mask = Get<bool>();
    reconstruction->has_source_rules = Get<bool>();
    for (int axis = 0; axis < 3; ++axis) scene.world_offset[axis] = Get<double>();
    std::map<uint32_t, std::vector<int>> views_of_point;
    std::vector<ImageSource> sources;
    for (size_t v = 0; v < sizes_.num_views; ++v) {
      sources.push_back(ReadView(reconstruction));
      const SeedList list = Get<SeedList>();
      if (!view_names.contains(scene.views.back().name)) continue;
      for (uint64_t e = list.begin; e < list.end; ++e) {
        std::vector<int>& views = views_of_point[EntryAt(e)];
        if (list.sees_them) views.push_back(static_cast<int>(v));
      }
    }
    // Whether there are points at all is asked, too.
    if (views_of_point.empty() && sizes_.num_points > 0) views_of_point[0];
    for (const auto& [p, views] : views_of_point) {
      const Position x = PointAt(p);
      scene.points.push_back({Eigen::Vector3d(x[0], x[1], x[2]), Color::Zero(), 0, views});
    }
    sources_ = std::move(sources);
  }

  std::vector<ImageSource> TakeSources() { return std::move(sources_); }

 private:
  [[noreturn]] void Fail() const {
    throw InputError(path_.string(), "is no scene for jobs of this version", "start the run again");
  }

  std::span<const char> Take(uint64_t num_bytes) {
    if (num_bytes > bytes_.size() - at_) Fail();
    const auto taken = bytes_.subspan(at_, num_bytes);
    at_ += num_bytes;
    return taken;
  }
  template <class T>
  T Get() {
    T value;
    std::memcpy(&value, Take(sizeof value).data(), sizeof value);
    return value;
  }
  std::string GetText() {
    const auto text = Take(Get<uint64_t>());
    return {text.begin(), text.end()};
  }
  template <class T>
  static T At(std::span<const char> bytes, uint64_t index) {
    T value;
    std::memcpy(&value, bytes.data() + index * sizeof value, sizeof value);
    return value;
  }
  uint32_t EntryAt(uint64_t e) const {
    if (e >= sizes_.num_entries) Fail();
    return At<uint32_t>(entries_, e);
  }
  Position PointAt(uint32_t p) const {
    if (p >= sizes_.num_points) Fail();
    return At<Position>(points_, p);
  }

  ImageSource ReadView(Reconstruction* reconstruction) {
    View view;
    view.image_id = Get<ImageId>();
    view.name = GetText();
    view.camera = Get<PinholeCamera>();
    for (int i = 0; i < 9; ++i) view.cam_from_world.rotation(i / 3, i % 3) = Get<double>();
    for (int i = 0; i < 3; ++i) view.cam_from_world.translation[i] = Get<double>();
    view.has_photo = Get<bool>();
    ImageSource source;
    source.path = (fs::path(reconstruction->scene.image_folder) / view.name).string();
    source.mask_path = GetText();
    source.camera = view.camera;
    source.alpha_is_mask = Get<bool>();
    source.is_missing = !view.has_photo;
    reconstruction->scene.views.push_back(std::move(view));
    reconstruction->depth_ranges.push_back(Get<DepthRange>());
    std::vector<Neighbor>& neighbors = reconstruction->neighbors.emplace_back();
    const auto count = Get<uint64_t>();
    for (uint64_t i = 0; i < count; ++i) neighbors.push_back(Get<Neighbor>());
    return source;
  }

  const fs::path path_;
  const MappedFile file_;
  const std::span<const char> bytes_;
  uint64_t at_ = 0;
  Sizes sizes_;
  std::span<const char> points_, entries_;
  std::vector<ImageSource> sources_;
};

}  // namespace

void WriteJobScene(const fs::path& path, const Reconstruction& reconstruction) {
  SceneWriter(path, reconstruction).Write();
}

ReconstructionPtr ReadJobScene(const fs::path& path, const std::set<std::string>& view_names,
                               std::shared_ptr<const WorkspaceFiles> files,
                               const ReconstructionOptions& options, const RunContext& context) {
  RequireValid(options);
  auto reconstruction = std::make_shared<Reconstruction>();
  SceneReader reader(path);
  reader.Read(view_names, reconstruction.get());
  reconstruction->files = std::move(files);
  reconstruction->options = options;
  reconstruction->memory_budget_bytes = context.memory_budget_bytes;
  reconstruction->num_threads = context.num_threads();
  reconstruction->images =
      std::make_unique<ImageStore>(reader.TakeSources(), ImageOptionsOf(options, context));
  return reconstruction;
}

fs::path JobScenePath(const fs::path& root) { return JobsFolder(root) / "scene"; }

std::set<std::string> ViewsOfStereoTasks(const std::vector<std::string>& task_names) {
  std::set<std::string> views;
  const std::string stage = std::string(kStereoStage) + "/";
  for (const std::string& name : task_names) {
    const size_t slash = name.find('/', stage.size());
    if (!name.starts_with(stage) || slash == std::string::npos) return {};
    views.insert(name.substr(slash + 1));
  }
  return views;
}

}  // namespace lsmvs
