#include "lsmvs/cli/program.h"

int main(int argc, char** argv) {
  return lsmvs::RunCommandTable(lsmvs::CommandTable(), {argv + 1, argv + argc});
}
