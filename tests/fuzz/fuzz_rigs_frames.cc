#include "fuzz_input.h"
#include "lsmvs/colmap_adapter/model/sparse_model_parts.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace lsmvs;
  fuzz::FuzzInput input(data, size);
  const auto rigs = fuzz::PutFile("rigs.bin", input.NextPiece());
  const auto frames = fuzz::PutFile("frames.bin", input.Rest());
  fuzz::ExpectInputErrorAtMost([&] {
    SparseModel model;
    model.cameras = {{CameraId{1}, 1, 640, 480, {500, 500, 320, 240}}};
    model.images = {{ImageId{1}, {}, CameraId{1}, "a", 0, {}},
                    {ImageId{2}, {}, CameraId{1}, "b", 0, {}}};
    internal::ReadRigsBinary(rigs, &model);
    internal::ReadFramesBinary(frames, &model);
    CheckSparseModel(model, rigs);
    RegisteredImageOrder(model);
  });
  return 0;
}
