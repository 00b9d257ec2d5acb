// Loops of edges that have one face, longest first (in space), as lists of vertices. A vertex at which several loops meet
// ends one of them.
export function borderLoops(positions, indices) {
  const next = borderEdges(indices, positions.length / 3);
  const loops = [];
  for (const start of [...next.keys()]) {
    const loop = [];
    for (let v = start; next.has(v);) {
      loop.push(v);
      const followers = next.get(v);
      const w = followers.pop();
      if (!followers.length) next.delete(v);
      v = w;
    }
    if (loop.length) loops.push(loop);
  }
  const length = new Map(loops.map((loop) => [loop, loopLength(positions, loop)]));
  return loops.sort((a, b) => length.get(b) - length.get(a));
}

// For each vertex that a border edge leaves, where it leads.
function borderEdges(indices, numVertices) {
  const keys = new Float64Array(indices.length); // edge * 2 + direction
  for (let i = 0; i < indices.length; ++i) {
    const a = indices[i], b = indices[i % 3 === 2 ? i - 2 : i + 1];
    keys[i] = 2 * (Math.min(a, b) * numVertices + Math.max(a, b)) + (a > b ? 1 : 0);
  }
  keys.sort();
  const edge = (i) => Math.floor(keys[i] / 2);
  const next = new Map();
  for (let i = 0; i < keys.length; ++i) {
    if ((i > 0 && edge(i - 1) === edge(i)) || (i + 1 < keys.length && edge(i + 1) === edge(i))) continue;
    const low = Math.floor(edge(i) / numVertices), high = edge(i) % numVertices;
    const [from, to] = keys[i] % 2 ? [high, low] : [low, high];
    if (next.has(from)) next.get(from).push(to);
    else next.set(from, [to]);
  }
  return next;
}

function loopLength(positions, loop) {
  let sum = 0;
  loop.forEach((v, k) => {
    const w = loop[(k + 1) % loop.length];
    sum += Math.hypot(...[0, 1, 2].map((c) => positions[3 * w + c] - positions[3 * v + c]));
  });
  return sum;
}
