// The page of a rendezvous: numbers to edit, the problem they make, its plan drawn. Positions in km, speeds in m/s.
// Frame of the station, on a circular orbit: radial (up) and along the velocity. Motion by Clohessy and Wiltshire, 1960.
"use strict";

const rendezvous = (() => {
  const RATE = Math.sqrt(398600.4418 / (6378.137 + 400) ** 3); // rad/s, a circular orbit at 400 km
  const KM = 1e-3 / RATE; // km for 1 m/s over 1/RATE

  // The state (radial, along, and their rates) a time later; rates in m/s.
  function coasted([x, y, u, v], seconds) {
    const angle = RATE * seconds, s = Math.sin(angle), c = Math.cos(angle);
    return [
      (4 - 3 * c) * x + (s * u + 2 * (1 - c) * v) * KM,
      6 * (s - angle) * x + y + (2 * (c - 1) * u + (4 * s - 3 * angle) * v) * KM,
      (3 * s * x) / KM + c * u + 2 * s * v,
      (6 * (c - 1) * x) / KM - 2 * s * u + (4 * c - 3) * v,
    ];
  }

  // On a circular orbit of its own: above the station it falls behind.
  const start = ({ radial, along }) => [radial, along, 0, (-1.5 * radial) / KM];
  const duration = ({ revolutions }) => (2 * Math.PI * revolutions) / RATE;
  const times = (wish) => Array.from({ length: wish.impulses }, (_, k) => (duration(wish) * k) / (wish.impulses - 1));

  // min Σ tₖ  s.t.  ‖Δvₖ‖ ≤ tₖ ≤ largest, at rest at the station in the end. Unknowns: Δv (2 an impulse), then t.
  function problem(wish) {
    const count = wish.impulses, n = 3 * count, A = [], G = [];
    times(wish).forEach((time, k) => {
      [[0, 0, 1, 0], [0, 0, 0, 1]].forEach((push, axis) =>
        coasted(push, duration(wish) - time).forEach((value, row) => A.push([row, 2 * k + axis, value])));
      G.push([k, 2 * count + k, 1], [count + 3 * k, 2 * count + k, -1]);
      G.push([count + 3 * k + 1, 2 * k, -1], [count + 3 * k + 2, 2 * k + 1, -1]);
    });
    return {
      schema: "orbsoc.problem/1", n, p: 4, m: 4 * count,
      c: Array.from({ length: n }, (_, i) => (i < 2 * count ? 0 : 1)),
      A: conic.columns(A, n), b: coasted(start(wish), duration(wish)).map((value) => -value),
      G: conic.columns(G, n), h: Array.from({ length: 4 * count }, (_, i) => (i < count ? wish.largest : 0)),
      cones: { l: count, q: new Array(count).fill(3) },
    };
  }

  // Positions along the plan, and at its impulses.
  function flown(wish, x) {
    let state = start(wish);
    const path = [], at = [];
    const moments = times(wish);
    moments.forEach((time, k) => {
      at.push(state.slice(0, 2));
      state = [state[0], state[1], state[2] + x[2 * k], state[3] + x[2 * k + 1]];
      const coast = (moments[k + 1] ?? time) - time;
      for (let i = 0; i <= 40; i++) path.push(coasted(state, (coast * i) / 40).slice(0, 2));
      state = coasted(state, coast);
    });
    return { path, at, end: state };
  }

  return { problem, flown, times };
})();

function showRendezvous(root) {
  const field = (name) => root.querySelector(`[name=${name}]`);
  const names = ["radial", "along", "revolutions", "impulses", "largest"];
  const [WIDTH, HEIGHT, EDGE] = [720, 380, 75];
  const svg = root.querySelector("svg");

  const wish = () => Object.fromEntries(names.map((name) => [name, Number(field(name).value)]));

  function draw(plan, dv) {
    const all = [...plan.path, [0, 0]];
    const [low, high] = [Math.min, Math.max].map((best) => [0, 1].map((i) => best(...all.map((point) => point[i]))));
    const scale = Math.min((WIDTH - 2 * EDGE) / (high[1] - low[1] || 1), (HEIGHT - 2 * EDGE) / (high[0] - low[0] || 1));
    const middle = [(high[0] + low[0]) / 2, (high[1] + low[1]) / 2];
    const place = ([radial, along]) => [WIDTH / 2 + (along - middle[1]) * scale, HEIGHT / 2 - (radial - middle[0]) * scale];
    const line = plan.path.map((point) => place(point).map((value) => value.toFixed(1)).join(",")).join(" ");
    const most = Math.max(...plan.at.map((_, k) => Math.hypot(dv[2 * k], dv[2 * k + 1])));
    const arrows = plan.at.map((point, k) => {
      const [x, y] = place(point), size = 60 / (most || 1);
      return Math.hypot(dv[2 * k], dv[2 * k + 1]) < 1e-4 ? `<circle cx="${x}" cy="${y}" r="3" class="quiet"/>`
        : `<line x1="${x}" y1="${y}" x2="${x + dv[2 * k + 1] * size}" y2="${y - dv[2 * k] * size}" class="push"/>
           <circle cx="${x}" cy="${y}" r="4" class="push"/>`;
    });
    const [sx, sy] = place([0, 0]), [bx, by] = place(plan.at[0]);
    const round = 10 ** Math.floor(Math.log10(160 / scale)), bar = round * scale;
    svg.innerHTML = `<polyline points="${line}" class="path"/>${arrows.join("")}
      <rect x="${sx - 6}" y="${sy - 6}" width="12" height="12" class="station"/><text x="${sx + 10}" y="${sy - 8}">station</text>
      <circle cx="${bx}" cy="${by}" r="9" class="start"/><text x="${bx + 12}" y="${by + 18}">start</text>
      <line x1="${EDGE}" y1="${HEIGHT - 12}" x2="${EDGE + bar}" y2="${HEIGHT - 12}" class="bar"/>
      <text x="${EDGE + bar + 6}" y="${HEIGHT - 8}">${round} km</text>
      <text x="${WIDTH - 130}" y="${HEIGHT - 8}">velocity →</text>`;
  }

  function solve() {
    const wanted = wish();
    for (const name of names) root.querySelector(`[data-of=${name}]`).textContent = wanted[name];
    const problem = rendezvous.problem(wanted);
    const begun = performance.now();
    const answer = conic.solve(problem);
    const milliseconds = performance.now() - begun;
    const solved = answer.status === "SOLVED";
    const plan = rendezvous.flown(wanted, solved ? answer.x : new Float64Array(2 * wanted.impulses));
    draw(plan, solved ? answer.x : new Float64Array(2 * wanted.impulses));
    const rows = solved
      ? rendezvous.times(wanted).map((time, k) => `<tr><td>${(time / 60).toFixed(1)}</td><td>${answer.x[2 * k].toFixed(3)}</td><td>${answer.x[2 * k + 1].toFixed(3)}</td></tr>`)
      : [];
    const say = solved ? `Δv ${answer.objective.toFixed(3)} m/s` : "no plan with these numbers; the path is the drift";
    root.querySelector(".said").textContent =
      `${answer.status} · ${say} · ${answer.iterations} iterations · ${milliseconds.toFixed(1)} ms`;
    root.querySelector(".bits").textContent = conic.bits(answer);
    root.querySelector("tbody").innerHTML = rows.join("");
    root.querySelector("a[download]").href = `data:application/json,${encodeURIComponent(JSON.stringify(problem))}`;
    return { problem, milliseconds, bits: conic.bits(answer), status: answer.status, end: plan.end };
  }

  for (const name of names) field(name).addEventListener("input", solve);
  solve();
  return solve;
}
