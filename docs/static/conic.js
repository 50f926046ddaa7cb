// A cone problem as in files of schema orbsoc.problem/1, solved by the core crate compiled to WebAssembly.
// solver.js, which the build writes, holds the module as text, so that pages work from file://.
"use strict";

const conic = (() => {
  const bytes = Uint8Array.from(atob(ORBSOC_WASM), (letter) => letter.charCodeAt(0));
  const core = new WebAssembly.Instance(new WebAssembly.Module(bytes)).exports;

  function write(room, View, values) {
    const place = room(values.length); // the memory may grow here, so that views are made after it
    new View(core.memory.buffer, place, values.length).set(values);
  }

  // The vectors x, y, z, s (Float64Array), and status, objective, iterations, worst residual; throws what is wrong.
  function solve(problem) {
    const { n, p, m, cones } = problem;
    const none = { indptr: new Array(n + 1).fill(0), indices: [], data: [] };
    const [P, A, G] = ["P", "A", "G"].map((name) => problem[name] ?? none);
    const sizes = [n, p, m, cones.l, cones.q.length, ...[P, A, G].map((each) => each.data.length)];
    write(core.integers, Uint32Array, [sizes, cones.q, ...[P, A, G].flatMap((each) => [each.indptr, each.indices])].flat());
    const h = problem.h.map((value) => (value === "inf" ? Infinity : value));
    write(core.numbers, Float64Array, [P.data, problem.c, A.data, problem.b, G.data, h].flat());
    const length = core.solve();
    const status = new TextDecoder().decode(new Uint8Array(core.memory.buffer, core.text(), core.text_length()));
    if (length === 0) throw new Error(status);
    const answer = new Float64Array(core.memory.buffer, core.answer(), length).slice();
    let at = 0;
    const [x, y, z, s] = [n, p, m, m].map((size) => answer.subarray(at, (at += size)));
    const [objective, iterations, worst] = answer.subarray(at);
    return { status, x, y, z, s, objective, iterations, worst };
  }

  // FNV-1a over the bits of x, y, z and s, a word of 64 bits a step.
  function bits({ x, y, z, s }) {
    let found = 0xcbf29ce484222325n;
    for (const vector of [x, y, z, s])
      for (const word of new BigUint64Array(vector.slice().buffer))
        found = BigInt.asUintN(64, (found ^ word) * 0x100000001b3n);
    return found.toString(16).padStart(16, "0");
  }

  // Columns of a matrix given by entries [row, column, value], in any order.
  function columns(entries, n) {
    const sorted = entries.filter(([, , value]) => value !== 0).sort((a, b) => a[1] - b[1] || a[0] - b[0]);
    const indptr = Array.from({ length: n + 1 }, (_, column) => sorted.filter((entry) => entry[1] < column).length);
    return { indptr, indices: sorted.map((entry) => entry[0]), data: sorted.map((entry) => entry[2]) };
  }

  return { solve, bits, columns };
})();
