#include "lsmvs/surface/minimum_cut.h"

#include "lsmvs/surface/cell_complex.h"
#include "lsmvs/surface/minimum_cut_internal.h"

namespace lsmvs {

template <class Node>
int64_t MaximizeFlow(std::vector<Node>* nodes, const RunContext& context) {
  return internal::BreadthFirstFlow<Node>(nodes, context).Run();
}

template int64_t MaximizeFlow(std::vector<CutNode>*, const RunContext&);
template int64_t MaximizeFlow(std::vector<Cell>*, const RunContext&);

}  // namespace lsmvs
