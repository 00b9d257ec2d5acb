#include "fuzz_input.h"
#include "lsmvs/colmap_adapter/model/sparse_model_parts.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace lsmvs;
  const auto path = fuzz::PutFile("cameras.bin", fuzz::FuzzInput(data, size).Rest());
  fuzz::ExpectInputErrorAtMost([&] {
    SparseModel model;
    internal::ReadCamerasBinary(path, &model);
    CheckSparseModel(model, path);
  });
  return 0;
}
