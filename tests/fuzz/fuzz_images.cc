#include "fuzz_input.h"
#include "lsmvs/colmap_adapter/model/sparse_model_parts.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace lsmvs;
  const auto path = fuzz::PutFile("images.bin", fuzz::FuzzInput(data, size).Rest());
  for (const bool keep_points2d : {true, false}) {
    fuzz::ExpectInputErrorAtMost([&] {
      SparseModel model;
      model.cameras = {{CameraId{1}, 1, 640, 480, {500, 500, 320, 240}}};
      internal::ReadImagesBinary(path, keep_points2d, &model);
      CheckSparseModel(model, path);
    });
  }
  return 0;
}
