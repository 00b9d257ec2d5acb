#include "fuzz_input.h"
#include "lsmvs/colmap_adapter/model/sparse_model_parts.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace lsmvs;
  const auto path = fuzz::PutFile("points3D.bin", fuzz::FuzzInput(data, size).Rest());
  fuzz::ExpectInputErrorAtMost([&] {
    SparseModel model;
    model.cameras = {{CameraId{1}, 1, 640, 480, {500, 500, 320, 240}}};
    model.images = {{ImageId{1}, {}, CameraId{1}, "a", 3, {}}};
    internal::ReadPoints3dBinary(path, &model);
    CheckSparseModel(model, path);
  });
  return 0;
}
