#include "fuzz_input.h"
#include "lsmvs/colmap_adapter/stereo_config.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace lsmvs;
  const auto path = fuzz::PutFile("stereo.cfg", fuzz::FuzzInput(data, size).Rest());
  fuzz::ExpectInputErrorAtMost([&] { ReadPatchMatchConfig(path); });
  fuzz::ExpectInputErrorAtMost([&] { ReadFusionConfig(path); });
  return 0;
}
