#include "fuzz_input.h"
#include "lsmvs/colmap_adapter/files/visibility_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace lsmvs;
  const auto path = fuzz::PutFile("fused.ply.vis", fuzz::FuzzInput(data, size).Rest());
  fuzz::ExpectInputErrorAtMost([&] { internal::ReadVisibilityFile(path, 5); });
  return 0;
}
