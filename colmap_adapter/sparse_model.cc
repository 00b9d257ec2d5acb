#include "lsmvs/colmap_adapter/sparse_model.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <unordered_map>

namespace lsmvs {

namespace {

// COLMAP keeps the data of a frame as a set, whatever their order in the file.
std::vector<SparseModel::Frame::Data> SortedData(const SparseModel::Frame& frame) {
  std::vector<SparseModel::Frame::Data> sorted = frame.data;
  const auto key = [](const SparseModel::Frame::Data& data) {
    return std::tuple(data.sensor.type, data.sensor.id, data.data_id);
  };
  std::sort(sorted.begin(), sorted.end(),
            [&](const auto& a, const auto& b) { return key(a) < key(b); });
  return sorted;
}

}  // namespace

std::vector<size_t> RegisteredImageOrder(const SparseModel& model) {
  std::vector<size_t> order;
  if (model.frames.empty()) {
    order.resize(model.images.size());
    std::iota(order.begin(), order.end(), size_t{0});
    return order;
  }
  std::unordered_map<uint64_t, size_t> position_of;
  for (size_t i = 0; i < model.images.size(); ++i) {
    position_of[static_cast<uint64_t>(model.images[i].image_id)] = i;
  }
  for (const SparseModel::Frame& frame : model.frames) {
    for (const SparseModel::Frame::Data& data : SortedData(frame)) {
      if (data.sensor.type != SparseModel::SensorType::kCamera) continue;
      order.push_back(position_of.at(data.data_id));
    }
  }
  return order;
}

void AddTrivialRigsAndFrames(SparseModel* model) {
  using enum SparseModel::SensorType;
  model->rigs.clear();
  model->frames.clear();
  for (const SparseModel::Camera& camera : model->cameras) {
    const auto id = static_cast<uint32_t>(camera.camera_id);
    model->rigs.push_back({RigId{id}, {{{kCamera, id}, std::nullopt}}});
  }
  for (const SparseModel::Image& image : model->images) {
    const auto id = static_cast<uint32_t>(image.image_id);
    const auto camera = static_cast<uint32_t>(image.camera_id);
    model->frames.push_back(
        {FrameId{id}, RigId{camera}, image.cam_from_world, {{{kCamera, camera}, id}}});
  }
}

}  // namespace lsmvs
