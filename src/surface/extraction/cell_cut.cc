#include "lsmvs/graph/minimum_cut-inl.h"
#include "lsmvs/surface/tetrahedralization.h"

namespace lsmvs {

template int64_t MaximizeFlow(std::vector<Cell>*, const RunContext&, size_t);

}  // namespace lsmvs
